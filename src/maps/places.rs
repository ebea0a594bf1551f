//! Places that several keys share.

use crate::geom::Vec2;

/// Which of `places` repeat an earlier one, that is, lie within `touching_mm` of it.
///
/// # Errors
/// What `meet` answers for two such places; it is given their indices in order.
pub(super) fn repeated<E>(
    places: &[Vec2],
    touching_mm: f64,
    mut meet: impl FnMut(usize, usize) -> Result<(), E>,
) -> Result<Vec<bool>, E> {
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by(|&i, &j| places[i].x.total_cmp(&places[j].x).then(i.cmp(&j)));
    let mut repeated = vec![false; places.len()];
    for (rank, &i) in order.iter().enumerate() {
        for &j in &order[rank + 1..] {
            if places[j].x - places[i].x > touching_mm {
                break;
            }
            if places[i].distance_squared(places[j]) <= touching_mm * touching_mm {
                meet(i.min(j), i.max(j))?;
                repeated[i.max(j)] = true;
            }
        }
    }
    Ok(repeated)
}
