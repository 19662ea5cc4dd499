#pragma once

namespace diffsac {

/// Real roots of c[0] + c[1] z + c[2] z² + c[3] z³ in ascending order, at most 3: closed form, then Newton steps.
/// A vanishing leading coefficient lowers the degree. Returns how many.
int SolveCubic(const double c[4], double roots[3]);

/// Real roots of Σ c[i] zⁱ, i = 0..10, in no particular order: isolated by a Sturm chain (Hook and McAree, "Using Sturm
/// sequences to bracket real roots of polynomial equations", Graphics Gems 1990), then Newton's method inside the
/// bracket. A root of even multiplicity is returned once or, by rounding, not at all; beside a cluster that rounding
/// cannot separate, rarely (2 of 300), a value that is no root. Returns how many, at most 10.
int RealRoots10(const double c[11], double roots[10]);

}  // namespace diffsac
