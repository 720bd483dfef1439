#include <gradus/io/mesh_files.hpp>
#include <gradus/remesh/chord_error.hpp>
#include <gradus/remesh/triangulation_for.hpp>

int main() {
    const gradus::SizingRule rule{.kind = gradus::SizingRule::Kind::ChordError, .value = 0.01, .hmin = 0.01, .hmax = 1};
    const auto surface = gradus::triangulation_for(gradus::read_mesh("teapot.obj"), rule);
    const gradus::GradationOptions gradation{.shock = 1.5};
    gradus::TriangulationBackground map = gradus::make_background(*surface, gradus::rule_within(rule.value, rule));
    gradus::grade(map.background.mesh, map.sizes, gradation);
    const gradus::ChordErrorResult made =
        gradus::remesh_within(*surface, map, rule.value, {.gradation = gradation, .hmin = rule.hmin});
    gradus::write_mesh("within.obj", {.points = made.result.mesh.points, .triangles = made.result.mesh.triangles});
    return made.kept ? 0 : 1;
}
