/// Curves in the parameters of a patch.
#pragma once

#include <Eigen/Core>
#include <memory>

namespace gradus {

/// The image of a curve in the parameters of a patch, over t in [0, 1], the parameter of the curve.
class PlaneCurve {
  public:
    virtual ~PlaneCurve() = default;
    virtual Eigen::Vector2d uv(double t) const = 0;
    virtual Eigen::Vector2d duv(double t) const = 0;
    virtual Eigen::Vector2d dduv(double t) const = 0;
    /// t of a point of the image, or of the one nearest to a point beside it. By samples and Newton's method unless an
    /// implementation knows better.
    virtual double parameter(const Eigen::Vector2d& uv) const;
    /// The segment between its ends, however fast t runs along it.
    virtual bool is_straight() const { return false; }
};

/// (1 - t) a + t b: exact at both ends, and everywhere in a coordinate that a and b share.
std::unique_ptr<const PlaneCurve> straight_image(const Eigen::Vector2d& a, const Eigen::Vector2d& b);

/// A point of a curve in space, and the first derivatives there.
struct CurveJet {
    Eigen::Vector3d p, d;
};
struct CurveJet2 {
    Eigen::Vector3d p, d, dd;
};

}  // namespace gradus
