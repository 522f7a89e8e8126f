//! Circles of light of a tile's pixels.

use super::super::curves::min;
use super::Tile;

impl Tile<'_, '_> {
    /// Writes the circle of the nearest depth in each pixel; where nothing is drawn, that of the farthest.
    pub(super) fn focus(&mut self, any: bool) {
        let Some((circle, circles)) = self.circles.take() else { return };
        let [left, right] = [self.low[0], self.high[0]].map(|x| x as usize);
        for y in self.low[1]..=self.high[1] {
            let row = self.picture.width * (y - self.origin[1]) as usize;
            let to = &mut circles[row + left..=row + right];
            if any {
                for (to, (_, depths)) in to.iter_mut().zip(self.row(&self.scratch.depth, y)) {
                    *to = circle.at(depths.iter().fold(1.0, |nearest, depth| min(*depth, nearest)));
                }
            } else {
                to.fill(circle.at(1.0));
            }
        }
    }
}
