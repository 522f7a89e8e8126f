//! Arithmetic of at least 27 digits, with which tests check what the program computes in 16.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// The sum of two numbers, the second less than half a last bit of the first (Dekker 1971, Knuth).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble(f64, f64);

/// 2π.
pub const TAU: DoubleDouble = DoubleDouble(std::f64::consts::TAU, 2.449_293_598_294_706_4e-16);

/// a + b, and what rounding it loses.
fn two_sum(a: f64, b: f64) -> DoubleDouble {
    let sum = a + b;
    let own = sum - a;
    DoubleDouble(sum, (a - (sum - own)) + (b - own))
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        Self(x, 0.0)
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (two_sum(self.0, other.0), two_sum(self.1, other.1));
        let sum = two_sum(high.0, high.1 + low.0);
        two_sum(sum.0, sum.1 + low.1)
    }
}

impl Neg for DoubleDouble {
    type Output = Self;

    fn neg(self) -> Self {
        Self(-self.0, -self.1)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        let product = self.0 * other.0;
        let lost = self.0.mul_add(other.0, -product);
        two_sum(product, lost + (self.0 * other.1 + self.1 * other.0))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        let first = self.0 / other.0;
        let rest = self - other * first.into();
        let second = rest.0 / other.0;
        let third = (rest - other * second.into()).0 / other.0;
        Self::from(first) + second.into() + third.into()
    }
}

impl std::iter::Sum for DoubleDouble {
    fn sum<I: Iterator<Item = Self>>(numbers: I) -> Self {
        numbers.fold(Self::default(), Add::add)
    }
}

impl DoubleDouble {
    /// The nearest double.
    pub fn rounded(self) -> f64 {
        self.0 + self.1
    }

    /// How far `x` is from it.
    pub fn error_of(self, x: f64) -> f64 {
        (self - x.into()).rounded().abs()
    }

    /// √x of a number that is not negative.
    pub fn sqrt(self) -> Self {
        if self.0 <= 0.0 {
            return Self::default();
        }
        // One of Newton's steps doubles the digits.
        let root = self.0.sqrt();
        Self::from(root) + (self - Self::from(root) * root.into()) / (2.0 * root).into()
    }

    /// eˣ.
    pub fn exp(self) -> Self {
        // Of a small part the series needs few terms; each squaring loses a bit.
        let squarings = (self.0.abs() * 16.0).max(1.0).log2().ceil() as i32;
        let part = 0.5f64.powi(squarings);
        let small = Self(self.0 * part, self.1 * part);
        let (mut power, mut term) = (Self::default(), Self::from(1.0));
        for n in 1..20 {
            power = power + term;
            term = term * small / f64::from(n).into();
        }
        (0..squarings).for_each(|_| power = power * power);
        power
    }

    /// sin x and cos x.
    pub fn sin_cos(self) -> (Self, Self) {
        let turns = (self / TAU).rounded().round();
        let x = self - TAU * turns.into();
        // Of a 64th, whose angle is doubled six times.
        let small = Self(x.0 / 64.0, x.1 / 64.0);
        let square = -(small * small);
        let (mut sin, mut cos) = (Self::default(), Self::default());
        let mut term = Self::from(1.0);
        for n in 0..12 {
            cos = cos + term;
            sin = sin + term / f64::from(2 * n + 1).into();
            term = term * square / f64::from((2 * n + 1) * (2 * n + 2)).into();
        }
        sin = sin * small;
        for _ in 0..6 {
            let two = Self::from(2.0);
            (sin, cos) = (two * sin * cos, Self::from(1.0) - two * sin * sin);
        }
        (sin, cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn number(high: f64, low: f64) -> DoubleDouble {
        DoubleDouble(high, low)
    }

    #[track_caller]
    fn is(found: DoubleDouble, known: DoubleDouble) {
        let error = (found - known).rounded().abs();
        assert!(error <= 1e-27 * known.rounded().abs().max(1.0), "off by {error:e}");
    }

    #[test]
    fn numbers_are_known_to_27_digits() {
        let (one, two, three) = (number(1.0, 0.0), number(2.0, 0.0), number(3.0, 0.0));
        is(one / three + one / three + one / three, one);
        is(one.exp(), number(std::f64::consts::E, 1.445_646_891_729_250_2e-16));
        is(two.sqrt(), number(std::f64::consts::SQRT_2, -9.667_293_313_452_913e-17));
        is((TAU / number(12.0, 0.0)).sin_cos().0, one / two);
        let (sin, cos) = (TAU / number(8.0, 0.0)).sin_cos();
        is(sin, cos);
        is(sin * cos, one / two);
        for x in [1e-9, 0.3, -2.0, 7.5, 40.0, 272.0, 1234.5] {
            let (sin, cos) = number(x, 0.0).sin_cos();
            is(sin * sin + cos * cos, one);
            assert!(sin.error_of(x.sin()) < 2e-16 && cos.error_of(x.cos()) < 2e-16, "{x}");
            let power = number(x, 0.0).exp();
            if x < 700.0 {
                is(power * number(-x, 0.0).exp(), one);
                assert!(power.error_of(x.exp()) <= 2e-16 * x.exp());
            }
        }
        assert_eq!(number(1.0, 1e-20).error_of(1.0), 1e-20);
    }
}
