//! The place of the picture in the window.

/// A picture's rectangle in the window, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Its upper left corner.
    pub corner: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
}

impl Place {
    /// Covers `rect` (points), as far as the window has pixels.
    pub fn of(rect: egui::Rect, pixels_per_point: f32, window: [u32; 2]) -> Self {
        let pixel = |points: f32, most: u32, round: fn(f32) -> f32| {
            (round(points * pixels_per_point).max(0.0) as u32).min(most)
        };
        let corner = [
            pixel(rect.left(), window[0], f32::floor),
            pixel(rect.top(), window[1], f32::floor),
        ];
        let end = [
            pixel(rect.right(), window[0], f32::ceil),
            pixel(rect.bottom(), window[1], f32::ceil),
        ];
        Self {
            corner,
            size: [
                end[0].saturating_sub(corner[0]),
                end[1].saturating_sub(corner[1]),
            ],
        }
    }

    /// Has it no pixels?
    pub fn is_empty(self) -> bool {
        self.size.contains(&0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Rect, pos2};

    #[test]
    fn the_picture_covers_its_part_of_the_window_and_no_more() {
        let rect = Rect::from_min_max(pos2(336.0, 0.0), pos2(1000.3, 700.7));
        assert_eq!(
            Place::of(rect, 1.0, [1000, 720]),
            Place {
                corner: [336, 0],
                size: [664, 701],
            }
        );
        assert_eq!(Place::of(rect, 2.0, [2000, 1440]).corner, [672, 0]);
        assert!(Place::of(Rect::NOTHING, 1.0, [100, 100]).is_empty());
        assert!(
            Place::of(
                Rect::from_min_max(pos2(336.0, 0.0), pos2(200.0, 80.0)),
                1.0,
                [200, 100]
            )
            .is_empty()
        );
    }
}
