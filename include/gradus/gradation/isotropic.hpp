/// Bounds the change of an isotropic size map along the edges of its background mesh. Sizes only ever go down.
/// An infinite size means "not set" and takes whatever its neighbours allow.
#pragma once

#include "gradus/mesh/tri_mesh.hpp"

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gradus {

/// Why every size is as large as the bound allows: it is the input, or tight against a neighbour that settled before.
struct Certificate {
    std::vector<int> parent;  ///< per vertex: the neighbour it is tight against, -1 where the size is the input
    std::vector<int> order;   ///< vertices with a parent, in the order in which they settled
};

/// A required size that the bound would have lowered; it was kept, so the bound fails on edges at this vertex.
struct RequiredConflict {
    int vertex = -1;     ///< required
    int neighbour = -1;  ///< at the other end of the edge that asks for most
    int origin = -1;     ///< vertex whose input size the demand comes from (through its neighbours)
    double size = 0;     ///< required size
    double needed = 0;   ///< largest size there that meets the bound
};

struct EdgeReduction {
    int lowered = 0;            ///< vertices whose size went down
    double largest_factor = 1;  ///< largest size before / after; infinite where an unset size was set
    int coarse_edges = 0;       ///< count_coarse_edges of the result (H-shock only)
    Certificate certificate;
    std::vector<RequiredConflict> conflicts;  ///< by vertex; empty when every required size fits
};

/// Lowers the sizes until no edge PQ has an H-variation |h(P) - h(Q)| / |PQ| above the bound. Exact and in one pass:
/// the result is the largest such map below the input. [Borouchaki 1998, eq. 14, settled from small to large]
/// @param bound     largest H-variation, dimensionless, > 0
/// @param size      one size h > 0 per vertex; lowered in place
/// @param required  vertices whose size may not be lowered
/// @throws std::invalid_argument if bound <= 0, a size is not positive, or a required size is unset
EdgeReduction limit_h_variation(const TriMesh& mesh, double bound, std::span<double> size,
                                std::span<const int> required = {});

/// Lowers the sizes until no edge has an H-shock above beta, by solving (20) instead of estimating its root by (23).
/// Exact and in one pass: the largest such map below the input, unless the result has coarse edges; there it is the
/// largest in the order in which sizes settle.
/// @param beta  largest H-shock, > 1; the result exceeds it by rounding only (1e-12, relative)
/// Else as limit_h_variation.
EdgeReduction limit_h_shock(const TriMesh& mesh, double beta, std::span<double> size,
                            std::span<const int> required = {});

/// One sweep over edges and vertices that proves a reduction: the bound holds (but on edges at required vertices), and
/// each size is the input or tight against a parent that settled before. Shares no search with the functions above.
/// @returns what is wrong, naming the first vertex or edge, or nothing
std::optional<std::string> check_variation_certificate(const TriMesh& mesh, double bound, std::span<const double> input,
                                                       std::span<const double> result, const Certificate& certificate,
                                                       std::span<const int> required = {});
std::optional<std::string> check_shock_certificate(const TriMesh& mesh, double beta, std::span<const double> input,
                                                   std::span<const double> result, const Certificate& certificate,
                                                   std::span<const int> required = {});

/// Largest size that a neighbour at distance L of a vertex of size h may have under an H-shock bound beta. [eq. 20]
/// @pre h > 0 finite, L >= 0, beta > 1
double shock_limit(double h, double L, double beta);

struct PaperReduction {
    int lowered = 0;
    int sweeps = 0;
    bool converged = false;  ///< false: stopped at the largest number of sweeps
};

/// The paper's procedures, for comparison: edges in index order, corrected by (14) or by the factor of (23), until a
/// sweep changes nothing; after the first sweep only edges with a changed end are visited. The one with (23) depends on
/// the order of the edges and lowers more than needed.
/// @param max_sweeps  >= 1
/// @throws as limit_h_variation
PaperReduction paper_h_variation(const TriMesh& mesh, double bound, std::span<double> size, int max_sweeps = 1000);
PaperReduction paper_h_shock(const TriMesh& mesh, double beta, std::span<double> size, int max_sweeps = 1000);

}  // namespace gradus
