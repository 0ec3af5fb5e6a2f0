//! Products of polynomials in Bernstein form.

/// The factor of the product of two Bernstein polynomials: B_i of degree a times B_j of degree b is this factor times
/// B_(i+j) of degree a + b. `counts` are a + 1 and b + 1, `indices` are i and j.
pub(crate) fn product_share(counts: [usize; 2], indices: [usize; 2]) -> f64 {
    let [a, b] = counts.map(|count| count - 1);
    let [i, j] = indices;
    binomial(a, i) * binomial(b, j) / binomial(a + b, i + j)
}

fn binomial(n: usize, k: usize) -> f64 {
    (1..=k).map(|i| (n + 1 - i) as f64 / i as f64).product()
}

/// The Bernstein coefficients of the product of two polynomials.
pub(crate) fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    unscaled(convolution(&scaled(a), &scaled(b)))
}

/// The Bernstein coefficients of f(φ(t)), from those of f and φ.
pub(crate) fn composition(f: &[f64], inner: &[f64]) -> Vec<f64> {
    let rest: Vec<f64> = inner.iter().map(|value| 1.0 - value).collect();
    let (inner, rest) = (scaled(inner), scaled(&rest));
    // De Casteljau's algorithm, whose parameter is a polynomial.
    let mut blended: Vec<Vec<f64>> = f.iter().map(|value| vec![*value]).collect();
    while blended.len() > 1 {
        let pairs = blended.windows(2).map(|pair| {
            let (before, after) = (convolution(&rest, &pair[0]), convolution(&inner, &pair[1]));
            before.iter().zip(after).map(|(a, b)| a + b).collect()
        });
        blended = pairs.collect();
    }
    blended.pop().map(unscaled).unwrap_or_default()
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
fn binomials(count: usize) -> impl Iterator<Item = f64> {
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
        let (a, b) = ([1.0, -2.0, 0.5, 3.0], [0.0, 0.3, 0.4, 1.0]);
        let (times, of) = (product(&a, &b), composition(&a, &b));
        assert_eq!((times.len(), of.len()), (7, 10));
        for step in 0..=10 {
            let t = f64::from(step) / 10.0;
            assert!((at(&times, t) - at(&a, t) * at(&b, t)).abs() < 1e-14);
            assert!((at(&of, t) - at(&a, at(&b, t))).abs() < 1e-14);
        }
    }
}
