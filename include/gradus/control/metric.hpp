/// Lengths in an isotropic metric.
#pragma once

namespace gradus {

/// ln(large / small) without cancellation for nearly equal sizes and without overflow for very different ones.
/// Infinite where only `large` is. @pre 0 < small <= large, small finite
double log_size_ratio(double small, double large);

/// Length of a segment of length L whose size varies geometrically from h_p to h_q. [Borouchaki 1998, eq. 7, 8]
/// Symmetric in the sizes to the last bit; 0 where a size is infinite (it asks for nothing, and the mean of 1/h tends
/// to 0).
/// @pre L >= 0 and finite, h_p > 0, h_q > 0
double metric_length(double L, double h_p, double h_q);

}  // namespace gradus
