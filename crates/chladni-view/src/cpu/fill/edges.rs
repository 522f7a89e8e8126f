//! Edge functions in whole numbers, of 32 or of 64 bits.

use crate::cpu::project::Corner;

/// An edge function: positive, or zero on an edge that is the triangle's own, to the right of the edge.
#[derive(Clone, Copy)]
pub(super) struct Edge<T> {
    pub(super) across: T,
    pub(super) down: T,
    /// At the start.
    pub(super) value: T,
}

impl<T: Whole> Edge<T> {
    #[inline(always)]
    pub(super) fn new(from: Corner, to: Corner, start: [i32; 2]) -> Self {
        let (across, down) = (i64::from(from.y) - i64::from(to.y), i64::from(to.x) - i64::from(from.x));
        let value = across * (i64::from(start[0]) - i64::from(from.x))
            + down * (i64::from(start[1]) - i64::from(from.y));
        // A sample on an edge belongs to the triangle that has it on its left or on its top.
        let own = across > 0 || (across == 0 && down > 0);
        Self { across: T::of(across), down: T::of(down), value: T::of(value - i64::from(!own)) }
    }
}

/// Whole numbers of one width.
pub(super) trait Whole: Copy {
    fn of(value: i64) -> Self;
    fn plus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn none_negative(a: Self, b: Self, c: Self) -> bool;
}

macro_rules! whole {
    ($type:ty) => {
        impl Whole for $type {
            #[inline(always)]
            fn of(value: i64) -> Self {
                value as $type
            }

            // Lanes beyond a triangle's box may go beyond the number; nobody looks at them.
            #[inline(always)]
            fn plus(self, other: Self) -> Self {
                self.wrapping_add(other)
            }

            #[inline(always)]
            fn times(self, other: Self) -> Self {
                self.wrapping_mul(other)
            }

            #[inline(always)]
            fn none_negative(a: Self, b: Self, c: Self) -> bool {
                (a | b | c) >= 0
            }
        }
    };
}
whole!(i32);
whole!(i64);
