#include "gradus/surface/plane_curve.hpp"

#include <algorithm>
#include <cmath>

namespace gradus {
namespace {

using Eigen::Vector2d;

class StraightImage final : public PlaneCurve {
  public:
    StraightImage(const Vector2d& a, const Vector2d& b)
        : a_(a), b_(b), axis_(std::abs(b.x() - a.x()) >= std::abs(b.y() - a.y()) ? 0 : 1) {}

    Vector2d uv(double t) const override {
        const auto at = [&](int k) { return a_[k] == b_[k] ? a_[k] : (1 - t) * a_[k] + t * b_[k]; };
        return {at(0), at(1)};
    }
    Vector2d duv(double) const override { return b_ - a_; }
    Vector2d dduv(double) const override { return {0, 0}; }
    double parameter(const Vector2d& uv) const override {
        const Vector2d along = b_ - a_;
        const double square = along.squaredNorm();
        if (!(square > 0)) return 0;
        const bool on_axis = a_[1 - axis_] == b_[1 - axis_];
        const double t = on_axis ? (uv[axis_] - a_[axis_]) / along[axis_] : along.dot(uv - a_) / square;
        return std::clamp(t, 0.0, 1.0);
    }
    bool is_straight() const override { return true; }

  private:
    Vector2d a_, b_;
    int axis_;  // along which it is longer
};

}  // namespace

double PlaneCurve::parameter(const Vector2d& uv) const {
    constexpr int kSamples = 32, kSteps = 20;
    int nearest = 0;
    double least = (this->uv(0) - uv).squaredNorm();
    for (int k = 1; k <= kSamples; ++k)
        if (const double d = (this->uv(static_cast<double>(k) / kSamples) - uv).squaredNorm(); d < least)
            least = d, nearest = k;
    // The foot lies between the neighbours of the nearest sample: Newton's method without the second derivative, kept
    // in a bracket that shrinks.
    const auto foot_near = [&](int sample) {
        double low = std::max(sample - 1, 0) / static_cast<double>(kSamples),
               high = std::min(sample + 1, kSamples) / static_cast<double>(kSamples);
        double t = static_cast<double>(sample) / kSamples;
        for (int step = 0; step < kSteps; ++step) {
            const Vector2d along = duv(t);
            const double slope = along.dot(this->uv(t) - uv), square = along.squaredNorm();
            if (slope == 0) break;
            (slope > 0 ? high : low) = t;
            const double newton = square > 0 ? t - slope / square : low;
            const double next = newton > low && newton < high ? newton : (low + high) / 2;
            if (std::abs(next - t) < 1e-16) break;
            t = next;
        }
        return t;
    };
    const double t = foot_near(nearest);
    if (nearest > 0 && nearest < kSamples) return t;
    // Where the curve returns to its start the foot may be on either side.
    const double other = foot_near(kSamples - nearest);
    return (this->uv(other) - uv).squaredNorm() < (this->uv(t) - uv).squaredNorm() ? other : t;
}

std::unique_ptr<const PlaneCurve> straight_image(const Vector2d& a, const Vector2d& b) {
    return std::make_unique<StraightImage>(a, b);
}

}  // namespace gradus
