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
fn what_older_files_say_is_known() {
    let remedy = |plugin| {
        let place = Place { file: 0, span: 0..0 };
        unknown_plugin(Class::Bsdf, plugin, &place).remedy.unwrap_or_default()
    };
    assert!(remedy("roughdiffuse").contains("\"diffuse\""));
    assert!(remedy("coating").contains("\"plastic\""));
    let remedy = formerly_property(Class::Medium, "sigma_s").unwrap();
    assert!(remedy.contains("sigma_a + sigma_s"));
}

#[test]
fn lists_read_well() {
    assert_eq!(either(&["a", "b", "c"]), "a, b or c");
    assert_eq!(either(&["a"]), "a");
    let many: Vec<&str> = vec!["n"; 14];
    assert!(listing(&many).ends_with("n and 2 more"));
}
