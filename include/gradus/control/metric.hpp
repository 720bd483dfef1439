/// Lengths in an isotropic metric.
#pragma once

namespace gradus {

/// Length of a segment of length L whose size varies geometrically from h_p to h_q. [Borouchaki 1998, eq. 7, 8]
/// Stable for nearly equal sizes; 0 where a size is infinite at both ends. @pre L >= 0, h_p > 0, h_q > 0
double metric_length(double L, double h_p, double h_q);

}  // namespace gradus
