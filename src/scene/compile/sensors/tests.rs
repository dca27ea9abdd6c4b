use super::tan_half_width;
use crate::scene::description::{FieldOfView, FovAxis};

/// Horizontal field of view in degrees.
fn x_fov(fov: FieldOfView, film: [f64; 2]) -> f64 {
    2.0 * tan_half_width(fov, film).atan().to_degrees()
}

#[test]
fn fields_of_view_are_mitsubas() {
    // Seen in Mitsuba 3.9.1 (validation/mitsuba/FACTS.md, 4 to 6).
    assert!((x_fov(FieldOfView::FocalLength(50.0), [768.0, 576.0]) - 38.1848).abs() < 1e-4);
    assert!((x_fov(FieldOfView::FocalLength(35.0), [200.0, 100.0]) - 57.8712).abs() < 1e-4);
    let degrees = |axis| x_fov(FieldOfView::Degrees { angle: 30.0, axis }, [200.0, 100.0]);
    assert!((degrees(FovAxis::X) - 30.0).abs() < 1e-12);
    assert!((degrees(FovAxis::Y) - 56.3736).abs() < 1e-4);
    assert!((degrees(FovAxis::Smaller) - 56.3736).abs() < 1e-4);
    assert!((degrees(FovAxis::Larger) - 30.0).abs() < 1e-12);
    assert!((degrees(FovAxis::Diagonal) - 26.9547).abs() < 1e-4);
}
