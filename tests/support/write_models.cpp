// Writes the models of the tests into a folder: patches as .bpt, triangulations as .off. For tests/same_meshes.sh.
#include <cstdio>
#include <filesystem>
#include <string>

#include "gradus/io/mesh_files.hpp"
#include "gradus/io/patch_files.hpp"
#include "support/models.hpp"
#include "support/parts.hpp"
#include "support/triangulations.hpp"

using namespace gradus;

namespace {

void write_all_patches(const std::string& folder) {
    const auto write = [&](const char* name, const models::Nets& nets) {
        write_patches(folder + "/" + name + ".bpt", {nets, ""});
    };
    write("teapot", models::teapot_nets());
    write("square", {models::flat_square()});
    write("bump", {models::bump()});
    write("uneven_square", {models::uneven_square()});
    write("wavy_sheet", models::wavy_sheet(3));
    write("hinge", models::hinge(1));
    write("mixed_degrees", models::mixed_degrees());
    write("differing_parameters", models::differing_parameters());
    write("cube", models::cube());
    write("cushion", models::cushion());
    write("sphere_octants", models::sphere_octants());
    write("sphere_cube", models::shuffled(models::sphere_cube()));
    write("torus", models::torus());
    write("cylinder", models::cylinder());
    write("cone", models::cone());
}

void write_all_triangulations(const std::string& folder) {
    const auto write = [&](const char* name, const TriangleSoup& soup) {
        write_mesh(folder + "/" + name + ".off", soup);
    };
    using namespace triangulations;
    write("fine_sphere", soup(sphere(4)));
    write("coarse_torus", soup(torus(40, 20)));
    write("noisy_torus", soup(noisy(torus(60, 30), 0.01)));
    write("flat_cube", soup(triangulations::cube(3)));
    write("capped_cylinder", soup(capped_cylinder(40, 8)));
    write("graph", soup(graph(30, [](double x, double y) { return 0.1 * std::sin(6 * x) * std::cos(5 * y); })));
    write("prism", parts::prism(parts::polygon(7), 1));
    write("needle_caps", parts::prism(parts::polygon(200), 1));
    write("rounded_plate", parts::prism(parts::rounded(3, 2, 0.3, 6), 0.5));
    write("twisted_bar", parts::twisted(parts::rounded(1, 1, 0.1, 2), 2, 0.7, 20));
    write("gear", parts::prism(parts::gear(12, 3, 0.8), 0.4));
    write("rounded_box", parts::rounded_box({3, 2, 1}, 0.2, 4));
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) return std::fprintf(stderr, "usage: write_models FOLDER\n"), 2;
    std::filesystem::create_directories(argv[1]);
    write_all_patches(argv[1]);
    write_all_triangulations(argv[1]);
}
