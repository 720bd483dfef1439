#include "gradus/surface/analytic.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace gradus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double pi = 3.14159265358979323846;

/// What all analytic surfaces share: a domain, and the lower jets taken from the second-order one.
class AnalyticSurface : public ParametricSurface {
  public:
    explicit AnalyticSurface(const Domain& domain) : domain_(domain) {}
    Domain domain() const final { return domain_; }
    Vector3d position(const Vector2d& uv) const override { return jet2(uv).p; }
    Jet1 jet1(const Vector2d& uv) const override {
        const Jet2 jet = jet2(uv);
        return {jet.p, jet.du, jet.dv};
    }

  private:
    Domain domain_;
};

class Plane final : public AnalyticSurface {
  public:
    Plane(const Vector3d& origin, const Vector3d& a, const Vector3d& b, const Domain& domain)
        : AnalyticSurface(domain), origin_(origin), a_(a), b_(b) {}
    Jet2 jet2(const Vector2d& uv) const override {
        const Vector3d zero = Vector3d::Zero();
        return {origin_ + uv.x() * a_ + uv.y() * b_, a_, b_, zero, zero, zero};
    }

  private:
    Vector3d origin_, a_, b_;
};

/// A profile (r(v), z(v)) turned about the z axis through `centre` by the angle u.
struct Profile {
    double r, z, dr, dz, ddr, ddz;
};

Jet2 turn(const Vector3d& centre, double u, const Profile& at) {
    const Vector3d e(std::cos(u), std::sin(u), 0), f(-e.y(), e.x(), 0), z = Vector3d::UnitZ();
    return {centre + at.r * e + at.z * z, at.r * f, at.dr * e + at.dz * z, -at.r * e, at.dr * f,
            at.ddr * e + at.ddz * z};
}

class Sphere final : public AnalyticSurface {
  public:
    Sphere(const Vector3d& centre, double radius)
        : AnalyticSurface({{0, -pi / 2}, {2 * pi, pi / 2}}), centre_(centre), radius_(radius) {}
    Jet2 jet2(const Vector2d& uv) const override {
        const double c = radius_ * std::cos(uv.y()), s = radius_ * std::sin(uv.y());
        return turn(centre_, uv.x(), {c, s, -s, c, -c, -s});
    }

  private:
    Vector3d centre_;
    double radius_;
};

class Torus final : public AnalyticSurface {
  public:
    Torus(const Vector3d& centre, double major, double minor)
        : AnalyticSurface({{0, 0}, {2 * pi, 2 * pi}}), centre_(centre), major_(major), minor_(minor) {}
    Jet2 jet2(const Vector2d& uv) const override {
        const double c = minor_ * std::cos(uv.y()), s = minor_ * std::sin(uv.y());
        return turn(centre_, uv.x(), {major_ + c, s, -s, c, -c, -s});
    }

  private:
    Vector3d centre_;
    double major_, minor_;
};

class Cylinder final : public AnalyticSurface {
  public:
    Cylinder(const Vector3d& base, double radius, double height)
        : AnalyticSurface({{0, 0}, {2 * pi, height}}), base_(base), radius_(radius) {}
    Jet2 jet2(const Vector2d& uv) const override { return turn(base_, uv.x(), {radius_, uv.y(), 0, 1, 0, 0}); }

  private:
    Vector3d base_;
    double radius_;
};

class Reparametrised final : public AnalyticSurface {
  public:
    Reparametrised(std::unique_ptr<const ParametricSurface> surface, const Eigen::Matrix2d& A, const Vector2d& b,
                   const Domain& domain)
        : AnalyticSurface(domain), surface_(std::move(surface)), A_(A), b_(b) {}
    Vector3d position(const Vector2d& x) const override { return surface_->position(A_ * x + b_); }
    Jet1 jet1(const Vector2d& x) const override {
        const Jet1 s = surface_->jet1(A_ * x + b_);
        return {s.p, A_(0, 0) * s.du + A_(1, 0) * s.dv, A_(0, 1) * s.du + A_(1, 1) * s.dv};
    }
    Jet2 jet2(const Vector2d& x) const override {
        const Jet2 s = surface_->jet2(A_ * x + b_);
        const auto second = [&](int i, int j) -> Vector3d {
            return A_(0, i) * A_(0, j) * s.duu + (A_(0, i) * A_(1, j) + A_(1, i) * A_(0, j)) * s.duv +
                   A_(1, i) * A_(1, j) * s.dvv;
        };
        return {s.p,
                A_(0, 0) * s.du + A_(1, 0) * s.dv,
                A_(0, 1) * s.du + A_(1, 1) * s.dv,
                second(0, 0),
                second(0, 1),
                second(1, 1)};
    }

  private:
    std::unique_ptr<const ParametricSurface> surface_;
    Eigen::Matrix2d A_;
    Vector2d b_;
};

void require_positive(const char* function, const char* name, double value) {
    if (!(value > 0) || !std::isfinite(value))
        throw std::invalid_argument(std::string(function) + ": " + name + " is " + std::to_string(value) +
                                    ", must be positive");
}

}  // namespace

std::unique_ptr<const ParametricSurface> make_plane(const Vector3d& origin, const Vector3d& a, const Vector3d& b,
                                                    const Domain& domain) {
    if (!(a.cross(b).norm() > 1e-12 * a.norm() * b.norm()))
        throw std::invalid_argument("make_plane: a and b are parallel");
    return std::make_unique<const Plane>(origin, a, b, domain);
}

std::unique_ptr<const ParametricSurface> make_sphere(const Vector3d& centre, double radius) {
    require_positive("make_sphere", "radius", radius);
    return std::make_unique<const Sphere>(centre, radius);
}

std::unique_ptr<const ParametricSurface> make_torus(const Vector3d& centre, double major, double minor) {
    require_positive("make_torus", "minor", minor);
    require_positive("make_torus", "major - minor", major - minor);
    return std::make_unique<const Torus>(centre, major, minor);
}

std::unique_ptr<const ParametricSurface> make_cylinder(const Vector3d& base, double radius, double height) {
    require_positive("make_cylinder", "radius", radius);
    require_positive("make_cylinder", "height", height);
    return std::make_unique<const Cylinder>(base, radius, height);
}

std::unique_ptr<const ParametricSurface> reparametrise(std::unique_ptr<const ParametricSurface> surface,
                                                       const Eigen::Matrix2d& A, const Vector2d& b,
                                                       const Domain& domain) {
    if (A.determinant() == 0 || !A.allFinite()) throw std::invalid_argument("reparametrise: A is singular");
    return std::make_unique<const Reparametrised>(std::move(surface), A, b, domain);
}

}  // namespace gradus
