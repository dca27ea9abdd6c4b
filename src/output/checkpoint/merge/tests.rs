use super::super::tests::header;
use super::*;

fn part([x, y, width, height]: [u32; 4], samples: std::ops::Range<u64>) -> RenderPart {
    RenderPart { region: Region { offset: [x, y], size: [width, height] }, samples }
}

/// A file that holds these parts of a picture of 10 × 8 pixels with 16 samples.
fn file(holds: &[RenderPart]) -> Header {
    let mut header = header([10, 8], 16);
    if let [part] = holds {
        header.film.extent.shown = part.region;
        header.film.extent.measured = part.region;
    }
    header.holds = holds.to_vec();
    header
}

const WHOLE: [u32; 4] = [0, 0, 10, 8];

fn planned(files: &[Header]) -> Result<Plan, Refusal> {
    plan(&files.iter().map(|header| (header, 0)).collect::<Vec<_>>())
}

/// Sums of boxes tell whether they are cut right: each pixel and sample is in one of them.
#[test]
fn what_is_left_of_a_box_and_what_is_cut_are_all_of_it() {
    let whole = part([2, 1, 6, 5], 4..12);
    for cut in [
        part([2, 1, 6, 5], 4..12),
        part([0, 0, 9, 9], 6..7),
        part([4, 2, 2, 2], 5..9),
        part([0, 3, 3, 9], 0..5),
        part([20, 3, 3, 9], 0..5),
        part([4, 2, 2, 2], 12..19),
    ] {
        let rest = whole.clone().without(&cut);
        let count = |pixel: [u32; 2], sample: u64, parts: &[RenderPart]| {
            parts.iter().filter(|p| p.region.within(pixel).is_some() && p.samples.contains(&sample)).count()
        };
        for pixel in whole.region.pixels() {
            for sample in whole.samples.clone() {
                let found = count(pixel, sample, &rest) + count(pixel, sample, std::slice::from_ref(&cut));
                assert_eq!(found, 1, "{cut}: {pixel:?} {sample}");
            }
        }
        assert!(rest.iter().all(|rest| whole.region.holds(rest.region)), "{cut}");
    }
}

#[test]
fn runs_of_samples_make_a_picture_and_what_is_missing_is_told() {
    let files = [file(&[part(WHOLE, 8..16)]), file(&[part(WHOLE, 0..4)])];
    let plan = planned(&files).expect("they fit");
    assert_eq!((plan.used, plan.missing), (vec![0, 1], vec![part(WHOLE, 4..8)]));
    assert_eq!(plan.holds, [part(WHOLE, 0..4), part(WHOLE, 8..16)]);
    let all = [files.as_slice(), &[file(&[part(WHOLE, 4..8)])]].concat();
    let plan = planned(&all).expect("they fit");
    assert_eq!((plan.holds, plan.missing), (vec![part(WHOLE, 0..16)], Vec::new()));
}

#[test]
fn rectangles_make_the_whole_picture() {
    let quarters = [[0, 0, 5, 4], [5, 0, 5, 4], [0, 4, 5, 4], [5, 4, 5, 4]];
    let files = quarters.map(|quarter| file(&[part(quarter, 0..16)]));
    let plan = planned(&files).expect("they fit");
    assert!(plan.missing.is_empty() && plan.extent.shown == Region::whole([10, 8]), "{plan:?}");
    let plan = planned(&files[1..]).expect("they fit");
    assert_eq!(plan.missing, [part([0, 0, 5, 4], 0..16)]);
    assert!(plan.is_even(16));
    let short = [file(&[part(quarters[0], 0..8)]), file(&[part(quarters[1], 0..16)])];
    assert!(!planned(&short).expect("they fit").is_even(16));
    // Whatever the others are cut into.
    let cut =
        [&[part([0, 0, 5, 4], 0..9), part([5, 0, 5, 4], 0..16)][..], &[part([0, 4, 10, 4], 0..7)]].concat();
    let cut: Vec<Header> = cut.iter().map(|part| file(std::slice::from_ref(part))).collect();
    let missing = planned(&cut).expect("they fit").missing;
    assert_eq!(missing, [part([0, 4, 10, 4], 7..16), part([0, 0, 5, 4], 9..16)]);
    // One rectangle alone is a picture of its own.
    let plan = planned(&[file(&[part(quarters[1], 0..8)]), file(&[part(quarters[1], 8..16)])]);
    let plan = plan.expect("they fit");
    assert!(plan.missing.is_empty() && plan.extent.shown.size == [5, 4], "{plan:?}");
}

#[test]
fn files_that_hold_nothing_new_are_left_out_and_overlaps_refused() {
    let [a, b] = [part(WHOLE, 0..8), part(WHOLE, 8..16)];
    let whole = file(&[part(WHOLE, 0..16)]);
    let [first, second] = [&a, &b].map(|part| file(std::slice::from_ref(part)));
    let plan = planned(&[first.clone(), whole.clone(), first.clone(), second.clone()]).expect("they fit");
    assert_eq!((plan.used, plan.redundant), (vec![1], vec![0, 2, 3]));
    let plan = planned(&[second.clone(), second.clone()]).expect("they fit");
    assert_eq!((plan.used, plan.redundant, plan.missing), (vec![0], vec![1], vec![a]));
    let crossing = file(&[part(WHOLE, 6..12)]);
    let refused = planned(&[crossing, second.clone()]);
    assert_eq!(refused, Err(Refusal::Overlap { files: [0, 1], part: part(WHOLE, 8..12) }));
    // The same samples, and other sums.
    let contradiction = super::plan(&[(&second, 1), (&second, 2)]);
    assert_eq!(contradiction, Err(Refusal::Contradiction { files: [0, 1] }));
    // Interrupted within a pass.
    let plan = planned(&[file(&[]), second]).expect("they fit");
    assert_eq!((plan.used, plan.unfinished, plan.missing), (vec![1], vec![0], vec![part(WHOLE, 0..8)]));
}

#[test]
fn parts_of_other_pictures_are_refused() {
    let first = file(&[part(WHOLE, 0..8)]);
    let mut other = file(&[part(WHOLE, 8..16)]);
    other.identity[1].1 = "7".to_owned();
    let refused = planned(&[first.clone(), first, other]);
    let values = ["0".to_owned(), "7".to_owned()];
    assert_eq!(refused, Err(Refusal::Different { files: [0, 2], what: "seed".to_owned(), values }));
}
