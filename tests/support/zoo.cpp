#include "support/zoo.hpp"

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace gradus::models {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

double off_sphere(const Vector3d& p) { return std::abs(p.norm() - 1); }
double off_torus(const Vector3d& p) { return std::abs(std::hypot(std::hypot(p.x(), p.y()) - 2, p.z()) - 0.5); }
double off_cylinder(const Vector3d& p) { return std::abs(std::hypot(p.x(), p.y()) - 1); }
double off_plane(const Vector3d& p) { return std::abs(p.z()); }
double off_cone(const Vector3d& p) { return std::abs(std::hypot(p.x(), p.y()) + p.z() - 1) / std::sqrt(2.0); }
double off_cube(const Vector3d& p) {
    double least = 1;
    for (int axis = 0; axis < 3; ++axis) least = std::min({least, std::abs(p[axis]), std::abs(p[axis] - 1)});
    return least;
}

/// Area of a model whose surface has no closed form: Gauss's rule with 4 x 4 points on 32 x 32 cells of each patch.
double integrated_area(const SurfaceModel& model) {
    const double a = std::sqrt(3.0 / 7 - 2.0 / 7 * std::sqrt(1.2)), b = std::sqrt(3.0 / 7 + 2.0 / 7 * std::sqrt(1.2));
    const double wa = (18 + std::sqrt(30.0)) / 36, wb = (18 - std::sqrt(30.0)) / 36;
    const double x[4] = {-b, -a, a, b}, w[4] = {wb, wa, wa, wb};
    constexpr int n = 32;
    double area = 0;
    for (int p = 0; p < model.num_patches(); ++p) {
        const Domain d = model.patch(p).domain();
        const Eigen::Vector2d cell = (d.max - d.min) / n;
        for (int k = 0; k < 16 * n * n; ++k) {
            const int i = k / 16 % n, j = k / 16 / n, gu = k % 4, gv = k / 4 % 4;
            const Jet1 jet = model.patch(p).jet1(
                {d.min.x() + (i + (1 + x[gu]) / 2) * cell.x(), d.min.y() + (j + (1 + x[gv]) / 2) * cell.y()});
            area += w[gu] * w[gv] / 4 * cell.x() * cell.y() * jet.du.cross(jet.dv).norm();
        }
    }
    return area;
}

Kind of_nets(const std::string& name, const Nets& nets, double area, double size, int loops, int genus = 0) {
    return {.name = name,
            .make = [nets] { return model_of(nets); },
            .area = area,
            .size = size,
            .loops = loops,
            .genus = genus};
}

Kind integrated(const std::string& name, const Nets& nets, double size, int loops) {
    return of_nets(name, nets, integrated_area(model_of(nets)), size, loops);
}

Kind with_creases(Kind kind, int creases) {
    kind.creases = creases;
    return kind;
}

Kind on(Kind kind, std::function<double(const Vector3d&)> off_surface) {
    kind.off_surface = std::move(off_surface);
    return kind;
}

}  // namespace

std::vector<Kind> zoo() {
    const double torus_area = 4 * pi * pi * 2 * 0.5;
    std::vector<Kind> kinds;
    kinds.push_back(on(of_nets("flat square", {flat_square()}, 1, 0.05, 1), off_plane));
    kinds.push_back(integrated("bump", {bump()}, 0.05, 1));
    for (int k = 1; k < 8; ++k)
        kinds.push_back(integrated("bump turned " + std::to_string(k), {turned(bump(), k)}, 0.05, 1));
    kinds.push_back(on(of_nets("uneven square", {uneven_square()}, 1, 0.05, 1), off_plane));
    kinds.push_back(integrated("sliver", {sliver(100)}, 0.005, 1));
    kinds.push_back(integrated("wavy sheet", wavy_sheet(3), 0.05, 1));
    kinds.push_back(integrated("wavy sheet shuffled", shuffled(wavy_sheet(3)), 0.05, 1));
    kinds.push_back(with_creases(of_nets("hinge", hinge(1), 2, 0.07, 1), 1));
    kinds.push_back(on(of_nets("coplanar hinge", hinge(0), 2, 0.07, 1), off_plane));
    kinds.push_back(integrated("mixed degrees", mixed_degrees(), 0.07, 1));
    kinds.push_back(on(of_nets("differing parameters", differing_parameters(), 2, 0.07, 1), off_plane));
    kinds.push_back(on(with_creases(of_nets("cube", cube(), 6, 0.1, 0), 12), off_cube));
    kinds.push_back(on(with_creases(of_nets("cube shuffled", shuffled(cube()), 6, 0.1, 0), 12), off_cube));
    kinds.push_back(with_creases(of_nets("cushion", cushion(), 2 * integrated_area(model_of({bump()})), 0.07, 0), 4));
    kinds.push_back(on(of_nets("cone", cone(), pi * std::sqrt(2.0), 0.07, 1), off_cone));
    kinds.push_back(on(of_nets("sphere of octants", sphere_octants(), 4 * pi, 0.15, 0), off_sphere));
    kinds.push_back(on(of_nets("sphere of octants shuffled", shuffled(sphere_octants()), 4 * pi, 0.15, 0), off_sphere));
    kinds.push_back(on(of_nets("sphere from a cube", sphere_cube(), 4 * pi, 0.15, 0), off_sphere));
    kinds.push_back(on(of_nets("sphere from a cube shuffled", shuffled(sphere_cube()), 4 * pi, 0.15, 0), off_sphere));
    kinds.push_back(on(of_nets("torus", torus(), torus_area, 0.2, 0, 1), off_torus));
    kinds.push_back(on(of_nets("torus shuffled", shuffled(torus()), torus_area, 0.2, 0, 1), off_torus));
    kinds.push_back(on(of_nets("cylinder", cylinder(), 4 * pi, 0.15, 2), off_cylinder));
    kinds.push_back(on(of_nets("cylinder shuffled", shuffled(cylinder()), 4 * pi, 0.15, 2), off_cylinder));
    kinds.push_back({.name = "sphere with seam",
                     .make = [] { return sphere_with_seam(); },
                     .area = 4 * pi,
                     .size = 0.15,
                     .off_surface = off_sphere});
    kinds.push_back({.name = "two hemispheres",
                     .make = [] { return two_hemispheres(); },
                     .area = 4 * pi,
                     .size = 0.15,
                     .off_surface = off_sphere});
    kinds.push_back({.name = "stretched sphere",
                     .make = [] { return model_of(stretched_sphere()); },
                     .area = 4 * pi,
                     .size = 0.15,
                     .off_surface = off_sphere});
    kinds.push_back({.name = "torus with seams",
                     .make = [] { return torus_with_seams(); },
                     .area = torus_area,
                     .size = 0.2,
                     .genus = 1,
                     .off_surface = off_torus});
    kinds.push_back({.name = "cylinder with seam",
                     .make = [] { return cylinder_with_seam(); },
                     .area = 4 * pi,
                     .size = 0.15,
                     .loops = 2,
                     .off_surface = off_cylinder});
    kinds.push_back({.name = "plate with hole",
                     .make = [] { return plate_with_hole(); },
                     .area = 1 - pi * 0.04,
                     .size = 0.05,
                     .loops = 2,
                     .off_surface = off_plane});
    kinds.push_back({.name = "disc in square",
                     .make = [] { return disc_in_square(); },
                     .area = 1,
                     .size = 0.05,
                     .loops = 1,
                     .off_surface = off_plane});
    kinds.push_back({.name = "sphere with hole",
                     .make = [] { return sphere_with_hole(); },
                     .area = 4 * pi - std::cos(0.3) * 2 * pi * 0.5 * std::cyl_bessel_j(1, 0.5),
                     .size = 0.1,
                     .loops = 1,
                     .off_surface = off_sphere});
    kinds.push_back({.name = "bored block",
                     .make = [] { return bored_block(); },
                     .area = 2 * (1 - pi * 0.04) + 4 * 0.4 + 2 * pi * 0.2 * 0.4,
                     .size = 0.05,
                     .genus = 1,
                     .creases = 14});
    return kinds;
}

Kind kind_of(const std::string& name) {
    for (Kind& kind : zoo())
        if (kind.name == name) return kind;
    throw std::invalid_argument("no kind of model is named " + name);
}

}  // namespace gradus::models
