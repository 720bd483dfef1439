/// Planar domains adapted to sizes or metrics given by formula: the loop, and what is said of it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gradus/remesh/adapt_planar.hpp"
#include "json.hpp"
#include "options.hpp"
#include "pictures.hpp"

namespace gradus::app {

/// What is wanted, by formula, or by a file with sizes or metrics at the vertices of a background: one of the two.
struct Wanted {
    std::string size, metric;
    std::string background = {};  ///< of such a file

    bool is_metric() const { return !metric.empty(); }
};

/// A mesh with the map that it was made with: sizes, or metrics.
struct Adaption {
    TriangleSoup mesh, background;
    std::vector<double> sizes;    ///< at the vertices of the mesh; of metrics those that their areas ask for
    std::vector<Tensor> metrics;  ///< empty where sizes are wanted
    /// At the vertices of the background: as wanted, and as corrected; of the two kinds the one that is wanted.
    struct Map {
        std::vector<double> sizes;
        std::vector<Tensor> metrics;
    } wanted, corrected;
    std::vector<PlanarAdaptIteration> iterations;
    RemeshStatistics statistics;
    bool converged = false, graded = true;

    bool is_metric() const { return !metrics.empty(); }
};

/// @throws ExpressionError; IoError, Failure naming a file
Adaption adapt_to(const Triangulation& domain, const Wanted& wanted, const PlanarAdaptOptions& options);

/// How metrics are corrected, as given. @throws UsageError
std::optional<TensorGradationOptions> tensor_gradation_of(const GradationChoice& choice,
                                                          std::optional<double> default_shock);
std::string to_text(const TensorGradationOptions& options);
/// Measures before and after, and what happened. @param vertices  of the background
std::string text_of(const TensorGradationOptions& options, const TensorGradationResult& result, std::size_t vertices);
Json json_of(const TensorGradationOptions& options, const TensorGradationResult& result);

/// A row for each iteration, below one with the headings.
std::vector<std::vector<std::string>> rows_of(const Adaption& adaption);
std::string outcome_of(const Adaption& adaption);
Json json_of(const Adaption& adaption);

/// `.vtu` and `.msh` with the fields size and metric.
void write_adapted(const std::string& path, const Adaption& adaption);
void write_map(const std::string& path, const Adaption::Map& map);

/// Seen from above. @param width  of what is seen, 0: all
Image draw_from_above(const TriangleSoup& mesh, const Eigen::Vector2d& middle = {0, 0}, double width = 0);

}  // namespace gradus::app
