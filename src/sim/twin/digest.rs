//! Twin of `shaders/digest.comp`.

use crate::sim::kernels::DigestParams;
use crate::sim::types::Meal;

/// Takes from each food what was eaten of it. Says whether the smell of any has become another: then [`super::scent`] is
/// due.
pub fn digest(params: &DigestParams, meals: &mut [Meal]) -> bool {
    let mut is_due = false;
    for meal in &mut meals[..params.food_count as usize] {
        let eaten = std::mem::take(&mut meal.eaten);
        if meal.amount == 0 || eaten == 0 {
            continue;
        }
        meal.remaining = meal.remaining.saturating_sub(eaten);
        let level = meal.level;
        meal.smell();
        is_due |= meal.level != level;
    }
    is_due
}
