#include <gradus/io/mesh_files.hpp>
#include <gradus/remesh/chord_error.hpp>

int main() {
    const gradus::Triangulation surface(gradus::read_mesh("teapot.obj"));
    const gradus::GradationOptions gradation{.shock = 1.5};
    const double chord_error = 0.01, hmin = 0.01;
    gradus::TriangulationBackground map = gradus::make_background(surface, gradus::rule_within(chord_error, {.hmin = hmin, .hmax = 1}));
    gradus::grade(map.background.mesh, map.sizes, gradation);
    const gradus::ChordErrorResult made = gradus::remesh_within(surface, map, chord_error, {.gradation = gradation, .hmin = hmin});
    gradus::write_mesh("within.obj", {.points = made.result.mesh.points, .triangles = made.result.mesh.triangles});
    return made.kept ? 0 : 1;
}
