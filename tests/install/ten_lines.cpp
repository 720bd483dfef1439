#include <gradus/control/geometric_size.hpp>
#include <gradus/gradation/grade.hpp>
#include <gradus/io/mesh_files.hpp>
#include <gradus/io/patch_files.hpp>
#include <gradus/remesh/parametric.hpp>

int main() {
    const gradus::SurfaceModel model = gradus::make_model(gradus::read_patches("teapot.bpt"));
    gradus::SizedBackground sized = gradus::make_background(model, {.value = 0.3, .hmin = 0.05, .hmax = 0.5});
    gradus::grade(sized.background.mesh, sized.sizes, {.shock = 1.5});
    const gradus::ControlSpace control(sized.background, sized.sizes);
    const gradus::SurfaceMesh mesh = gradus::remesh(model, control).mesh;
    gradus::write_mesh("teapot.obj", {.points = mesh.points, .triangles = mesh.triangles});
}
