#include "support/models.hpp"

#include <cmath>
#include <numbers>

namespace gradus::models {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

/// centre + radius (cos, sin) of an angle that turns once.
class CircleImage final : public PlaneCurve {
  public:
    CircleImage(const Vector2d& centre, double radius, double from = 0) : centre_(centre), r_(radius), from_(from) {}
    Vector2d uv(double t) const override { return centre_ + r_ * Vector2d(std::cos(at(t)), std::sin(at(t))); }
    Vector2d duv(double t) const override { return 2 * pi * r_ * Vector2d(-std::sin(at(t)), std::cos(at(t))); }
    Vector2d dduv(double t) const override { return -4 * pi * pi * (uv(t) - centre_); }

  private:
    double at(double t) const { return from_ + 2 * pi * (t == 1 ? 0 : t); }
    Vector2d centre_;
    double r_, from_;
};

std::unique_ptr<const PlaneCurve> circle(const Vector2d& centre, double radius, double from = 0) {
    return std::make_unique<CircleImage>(centre, radius, from);
}

class Drawing {
  public:
    int patch(Patch surface) {
        topology_.patches.push_back({std::move(surface), {}});
        return static_cast<int>(topology_.patches.size()) - 1;
    }
    int curve(std::optional<CurveKind> kind = {}) {
        topology_.curves.push_back({{}, kind});
        return static_cast<int>(topology_.curves.size()) - 1;
    }
    void loop(int patch) { topology_.patches[patch].loops.emplace_back(); }
    /// The next curve of the last loop of a patch.
    void use(int curve, int patch, std::unique_ptr<const PlaneCurve> image, bool reversed = false) {
        std::vector<CurveUse>& uses = topology_.curves[curve].uses;
        topology_.patches[patch].loops.back().push_back({curve, static_cast<int>(uses.size())});
        uses.push_back({patch, reversed, std::move(image)});
    }
    /// A loop of new boundary curves through some points.
    void polygon(int patch, const std::vector<Vector2d>& corners) {
        loop(patch);
        for (std::size_t k = 0; k < corners.size(); ++k)
            use(curve(), patch, straight_image(corners[k], corners[(k + 1) % corners.size()]));
    }
    SurfaceModel model() { return SurfaceModel(std::move(topology_)); }

  private:
    Topology topology_;
};

}  // namespace

SurfaceModel plate_with_hole(double radius) {
    Drawing d;
    const int plate = d.patch(make_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    d.polygon(plate, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    d.loop(plate);
    d.use(d.curve(), plate, circle({.65, .35}, radius), true);
    return d.model();
}

SurfaceModel disc_in_square(double radius) {
    Drawing d;
    const int square = d.patch(make_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
    // The disc has parameters of its own: turned by a right angle and in another unit.
    const int disc = d.patch(make_plane({.65, .35, 0}, {0, 2, 0}, {-2, 0, 0}));
    d.polygon(square, {{0, 0}, {1, 0}, {1, 1}, {0, 1}});
    const int rim = d.curve();
    d.loop(square);
    d.use(rim, square, circle({.65, .35}, radius), true);
    d.loop(disc);
    d.use(rim, disc, circle({0, 0}, radius / 2, -pi / 2));
    return d.model();
}

SurfaceModel sphere_with_hole(double latitude, double radius) {
    Drawing d;
    const int sphere = d.patch(make_sphere(Vector3d::Zero(), 1));
    const int seam = d.curve(), south = d.curve(CurveKind::Pole), north = d.curve(CurveKind::Pole);
    d.loop(sphere);
    d.use(south, sphere, straight_image({0, -pi / 2}, {2 * pi, -pi / 2}));
    d.use(seam, sphere, straight_image({2 * pi, -pi / 2}, {2 * pi, pi / 2}));
    d.use(north, sphere, straight_image({0, pi / 2}, {2 * pi, pi / 2}), true);
    d.use(seam, sphere, straight_image({0, -pi / 2}, {0, pi / 2}), true);
    d.loop(sphere);
    d.use(d.curve(), sphere, circle({4, latitude}, radius), true);
    return d.model();
}

SurfaceModel bored_block(double radius, double height) {
    Drawing d;
    const int low = d.patch(make_plane({0, 0, 0}, {1, 0, 0}, {0, 1, 0})),
              high = d.patch(make_plane({0, 0, height}, {1, 0, 0}, {0, 1, 0})),
              bore = d.patch(make_cylinder({.65, .35, 0}, radius, height));
    const Vector2d corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    int along[4], above[4], up[4];
    d.loop(low);
    d.loop(high);
    for (int k = 0; k < 4; ++k) {
        along[k] = d.curve(), above[k] = d.curve(), up[k] = d.curve();
        d.use(along[k], low, straight_image(corners[k], corners[(k + 1) % 4]));
        d.use(above[k], high, straight_image(corners[k], corners[(k + 1) % 4]));
    }
    for (int k = 0; k < 4; ++k) {
        const Vector2d a = corners[k], b = corners[(k + 1) % 4];
        const int wall = d.patch(make_plane({a.x(), a.y(), 0}, {b.x() - a.x(), b.y() - a.y(), 0}, {0, 0, height}));
        d.loop(wall);
        d.use(along[k], wall, straight_image({0, 0}, {1, 0}));
        d.use(up[(k + 1) % 4], wall, straight_image({1, 0}, {1, 1}));
        d.use(above[k], wall, straight_image({0, 1}, {1, 1}), true);
        d.use(up[k], wall, straight_image({0, 0}, {0, 1}), true);
    }
    const int bottom = d.curve(), top = d.curve(), seam = d.curve();
    d.loop(low);
    d.use(bottom, low, circle({.65, .35}, radius), true);
    d.loop(high);
    d.use(top, high, circle({.65, .35}, radius), true);
    d.loop(bore);
    d.use(bottom, bore, straight_image({0, 0}, {2 * pi, 0}));
    d.use(seam, bore, straight_image({2 * pi, 0}, {2 * pi, height}));
    d.use(top, bore, straight_image({0, height}, {2 * pi, height}), true);
    d.use(seam, bore, straight_image({0, 0}, {0, height}), true);
    return d.model();
}

}  // namespace gradus::models
