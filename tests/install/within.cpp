#include <gradus/io/mesh_files.hpp>
#include <gradus/remesh/mesh_triangulation.hpp>
#include <gradus/remesh/triangulation_for.hpp>

int main() {
    const gradus::SizingRule rule{.kind = gradus::SizingRule::Kind::ChordError, .value = 0.01, .hmin = 0.01, .hmax = 1};
    const gradus::MeshedTriangulation made =
        gradus::mesh_triangulation(gradus::triangulation_for(gradus::read_mesh("teapot.obj"), rule), rule,
                                   {.gradation = gradus::GradationOptions{.shock = 1.5}});
    const gradus::SurfaceMesh& mesh = made.mesh.result.mesh;
    gradus::write_mesh("within.obj", {.points = mesh.points, .triangles = mesh.triangles});
    return made.mesh.kept ? 0 : 1;
}
