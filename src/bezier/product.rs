//! Products of polynomials in Bernstein form.

/// The Bernstein coefficients of the product of two polynomials.
pub(crate) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    unscaled(convolution(&scaled(a), &scaled(b)))
}

/// The Bernstein coefficients of f(φ(t)) for several f of the same degree, from those of each f and of φ.
pub(crate) fn compositions<const N: usize>(f: [&[f64]; N], inner: &[f64]) -> [Vec<f64>; N] {
    let degree = f[0].len() - 1;
    let rest: Vec<f64> = inner.iter().map(|value| 1.0 - value).collect();
    let [powers, of_rest] = [inner, &rest].map(|factor| powers(&scaled(factor), degree));
    let mut sums = [(); N].map(|()| vec![0.0; powers[degree].len()]);
    for (i, binomial) in binomials(degree + 1).enumerate() {
        let basis = convolution(&powers[i], &of_rest[degree - i]);
        for (sum, f) in sums.iter_mut().zip(f) {
            sum.iter_mut().zip(&basis).for_each(|(sum, value)| *sum += f[i] * binomial * value);
        }
    }
    sums.map(unscaled)
}

/// The powers of a polynomial up to a degree, from its scaled coefficients.
fn powers(factor: &[f64], degree: usize) -> Vec<Vec<f64>> {
    let mut powers = vec![vec![1.0]];
    for i in 0..degree {
        powers.push(convolution(&powers[i], factor));
    }
    powers
}

/// Bernstein coefficients times binomial coefficients: of these, products are convolutions.
fn scaled(coefficients: &[f64]) -> Vec<f64> {
    coefficients.iter().zip(binomials(coefficients.len())).map(|(c, n)| c * n).collect()
}

fn unscaled(mut coefficients: Vec<f64>) -> Vec<f64> {
    let binomials = binomials(coefficients.len());
    coefficients.iter_mut().zip(binomials).for_each(|(c, n)| *c /= n);
    coefficients
}

/// The binomial coefficients of degree `count` − 1.
pub(crate) fn binomials(count: usize) -> impl Iterator<Item = f64> + Clone {
    (0..count).scan(1.0, move |next, i| {
        let binomial = *next;
        *next *= (count - 1 - i) as f64 / (i + 1) as f64;
        Some(binomial)
    })
}

fn convolution(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sums = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (sum, y) in sums[i..].iter_mut().zip(b) {
            *sum += x * y;
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bezier::bernstein;

    fn at(coefficients: &[f64], t: f64) -> f64 {
        let degree = coefficients.len() - 1;
        coefficients.iter().enumerate().map(|(i, c)| c * bernstein(degree, i, t)).sum()
    }

    #[test]
    fn products_and_compositions_have_the_values_of_their_polynomials() {
        let (a, b, c) = ([1.0, -2.0, 0.5, 3.0], [0.0, 0.3, 0.4, 1.0], [2.0, 0.0, 1.0, -1.0]);
        let (times, [of, of_other]) = (product(&a, &b), compositions([&a, &c], &b));
        assert_eq!((times.len(), of.len()), (7, 10));
        for step in 0..=10 {
            let t = f64::from(step) / 10.0;
            assert!((at(&times, t) - at(&a, t) * at(&b, t)).abs() < 1e-14);
            assert!((at(&of, t) - at(&a, at(&b, t))).abs() < 1e-14);
            assert!((at(&of_other, t) - at(&c, at(&b, t))).abs() < 1e-14);
        }
    }
}
