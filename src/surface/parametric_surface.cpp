#include "gradus/surface/parametric_surface.hpp"

namespace gradus {

void ParametricSurface::jets(std::span<const Eigen::Vector2d> uv, std::span<Jet2> jets) const {
    for (std::size_t i = 0; i < uv.size(); ++i) jets[i] = jet2(uv[i]);
}

}  // namespace gradus
