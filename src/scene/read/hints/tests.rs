use super::*;

#[test]
fn the_nearest_name_is_found_or_none() {
    let known = ["radius", "center", "to_world", "flip_normals"];
    assert_eq!(nearest("raduis", &known), Some("radius"));
    assert_eq!(nearest("toWorld", &known), Some("to_world"));
    assert_eq!(nearest("CENTRE", &known), Some("center"));
    assert_eq!(nearest("banana", &known), None);
    assert_eq!(nearest("x", &[]), None);
}

#[test]
fn lists_read_well() {
    assert_eq!(either(&["a", "b", "c"]), "a, b or c");
    assert_eq!(either(&["a"]), "a");
    let many: Vec<&str> = vec!["n"; 14];
    assert!(listing(&many).ends_with("n and 2 more"));
}
