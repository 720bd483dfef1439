#include "gradus/surface/locate.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>

namespace gradus {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// Half the squared distance to a point as a function of the parameters, to second order.
struct Objective {
    double value;
    Vector2d gradient;
    Eigen::Matrix2d first_form, hessian;

    Objective(const ParametricSurface& surface, const Vector2d& uv, const Vector3d& point) {
        const Jet2 jet = surface.jet2(uv);
        const Vector3d r = jet.p - point;
        value = r.squaredNorm() / 2;
        gradient = {r.dot(jet.du), r.dot(jet.dv)};
        first_form << jet.du.squaredNorm(), jet.du.dot(jet.dv), jet.du.dot(jet.dv), jet.dv.squaredNorm();
        hessian << r.dot(jet.duu), r.dot(jet.duv), r.dot(jet.duv), r.dot(jet.dvv);
        hessian += first_form;
    }
};

constexpr double kSafe = 1e-2;  // part of the first form that the Hessian must keep

/// Newton's step; by the first form alone (Gauss-Newton) where the Hessian is no safe guide.
Vector2d newton_step(const Objective& f) {
    constexpr double kSingular = 1e-24;  // squared sine, or ratio of speeds, below which a direction is left alone
    const double scale = f.first_form.trace();
    if (f.first_form.determinant() > kSingular * scale * scale) {
        const bool safe = f.hessian.determinant() > kSafe * f.first_form.determinant() &&
                          f.hessian(0, 0) > kSafe * f.first_form(0, 0);
        const Eigen::Matrix2d& m = safe ? f.hessian : f.first_form;
        return -Vector2d(m(1, 1) * f.gradient[0] - m(0, 1) * f.gradient[1],
                         m(0, 0) * f.gradient[1] - m(1, 0) * f.gradient[0]) /
               m.determinant();
    }
    // At a pole one direction stands still.
    const int k = f.first_form(0, 0) >= f.first_form(1, 1) ? 0 : 1;
    const double speed = f.first_form(k, k);
    Vector2d step(0, 0);
    if (speed > 0) step[k] = -f.gradient[k] / (f.hessian(k, k) > kSafe * speed ? f.hessian(k, k) : speed);
    return step;
}

/// Newton's step of t along a curve of the border.
double step_along(const Objective& f, const PlaneCurve& image, double t) {
    const Vector2d d = image.duv(t);
    const double slope = f.gradient.dot(d), speed = d.dot(f.first_form * d),
                 change = d.dot(f.hessian * d) + f.gradient.dot(image.dduv(t));
    return speed > 0 ? -slope / (change > kSafe * speed ? change : speed) : 0;
}

/// The way down to the closest point of one surface, inside the loops of its patch, or anywhere.
class Descent {
  public:
    Descent(const ParametricSurface& surface, const Vector3d& point, const Vector2d& start)
        : surface_(surface), point_(point), uv_(start), f_(surface, start, point) {}
    Descent(const SurfaceModel& model, const Vector3d& point, const SurfacePoint& start)
        : Descent(model.patch(start.patch), point, start.uv) {
        model_ = &model;
        patch_ = start.patch;
    }

    Projection run(double tolerance) {
        constexpr int kMostSteps = 50;
        bool arrived = false;
        for (int step = 0; step < kMostSteps && !arrived; ++step) {
            const Vector2d way = newton_step(f_);
            const double length = std::sqrt(std::max(0.0, way.dot(f_.first_form * way)));
            const bool moved = go(way) || slide();
            // A step this short was one of quadratic convergence: what remains is its square.
            arrived = !moved || length < tolerance;
        }
        return {{patch_, uv_}, std::sqrt(2 * f_.value), arrived};
    }

  private:
    /// Takes what of a step is inside, or the half, the quarter ... of it, where that is nearer.
    bool go(Vector2d step) {
        constexpr int kMostHalvings = 12;
        for (int half = 0; half < kMostHalvings; ++half, step /= 2) {
            if (!model_) {
                if (take(uv_ + step)) return true;
                continue;
            }
            const std::optional<SurfaceModel::Exit> exit = model_->exit({patch_, uv_}, step);
            if (!exit) {
                if (take(uv_ + step)) return true;
            } else {
                // The rest of the way along the border comes with the next step.
                if (take(model_->use(exit->use).image->uv(exit->t))) return true;
                if (exit->fraction <= 0) return false;
            }
        }
        return false;
    }

    /// Goes along the curve of the border that leads nearest.
    bool slide() {
        if (!model_) return false;
        constexpr int kMostHalvings = 12;
        for (const auto& [ref, t] : model_->border_at({patch_, uv_})) {
            const PlaneCurve& image = *model_->use(ref).image;
            double step = step_along(f_, image, t);
            for (int half = 0; half < kMostHalvings && step != 0; ++half, step /= 2)
                if (take(image.uv(std::clamp(t + step, 0.0, 1.0)))) return true;
        }
        return false;
    }

    bool take(const Vector2d& uv) {
        if (uv == uv_) return false;
        const Objective there(surface_, uv, point_);
        if (!(there.value < f_.value)) return false;
        uv_ = uv;
        f_ = there;
        return true;
    }

    const ParametricSurface& surface_;
    const Vector3d point_;
    Vector2d uv_;
    Objective f_;
    const SurfaceModel* model_ = nullptr;
    int patch_ = -1;
};

double tolerance_of(const SurfaceModel& model) { return 1e-9 * model.diagonal(); }

bool is_pole(const SurfaceModel& model, const UseRef& ref) { return model.curves()[ref.curve].kind == CurveKind::Pole; }

/// A start away from a pole, in the direction along it that leads nearest to the point.
std::optional<SurfacePoint> leave_pole(const SurfaceModel& model, const UseRef& pole, const Vector3d& point) {
    constexpr int kDirections = 16;
    const CurveUse& use = model.use(pole);
    std::optional<SurfacePoint> best;
    double best_gain = 0;
    for (int i = 0; i < kDirections; ++i) {
        const double t = (i + .5) / kDirections;
        Vector2d uv = use.image->uv(t);
        const Vector2d along = use.reversed ? Vector2d(-use.image->duv(t)) : use.image->duv(t),
                       inward = Vector2d(-along.y(), along.x()).normalized();
        const Jet1 jet = model.patch(use.patch).jet1(uv);
        const Vector3d direction = jet.du * inward.x() + jet.dv * inward.y();
        const double gain = direction.dot(point - jet.p), speed = direction.squaredNorm();
        if (!(speed > 0) || gain <= best_gain * std::sqrt(speed)) continue;
        best_gain = gain / std::sqrt(speed);
        uv += inward * gain / speed;
        if (model.contains({use.patch, uv})) best = SurfacePoint{use.patch, uv};
    }
    return best;
}

/// Where to go on from a foot on the border of its patch.
std::vector<SurfacePoint> ways_on(const SurfaceModel& model, const SurfacePoint& at, const Vector3d& point) {
    std::vector<SurfacePoint> starts;
    if (model.border_at(at).empty()) return starts;
    for (const SurfacePoint& place : places_of(model, at)) {
        bool pole = false;
        for (const auto& [ref, t] : model.border_at(place)) {
            if (!is_pole(model, ref)) continue;
            pole = true;
            if (const auto start = leave_pole(model, ref, point)) starts.push_back(*start);
        }
        if (!pole && !(place.patch == at.patch && place.uv == at.uv)) starts.push_back(place);
    }
    return starts;
}

}  // namespace

std::vector<SurfacePoint> places_of(const SurfaceModel& model, const SurfacePoint& at) {
    constexpr double kAtEnd = 1e-10;
    std::vector<SurfacePoint> places{at};
    const std::vector<SurfaceModel::OnBorder> border = model.border_at(at);
    if (border.empty()) return places;
    const auto& [ref, t] = border[0];
    const ModelCurve& curve = model.curves()[ref.curve];
    int vertex = -1;
    if (curve.kind == CurveKind::Pole || t <= kAtEnd)
        vertex = curve.ends[0];
    else if (t >= 1 - kAtEnd)
        vertex = curve.ends[1];
    if (vertex >= 0) {
        for (const SurfacePoint& place : model.vertices()[vertex].places)
            if (place.patch != at.patch || !place.uv.isApprox(at.uv, kAtEnd)) places.push_back(place);
        return places;
    }
    for (int other = 0; other < std::ssize(curve.uses); ++other)
        if (other != ref.use) places.push_back(model.on_curve(ref.curve, other, t));
    return places;
}

bool on_pole(const SurfaceModel& model, const SurfacePoint& at, int& along) {
    for (const auto& [ref, t] : model.border_at(at)) {
        if (!is_pole(model, ref)) continue;
        const Vector2d d = model.use(ref).image->duv(t).cwiseAbs();
        along = d.x() >= d.y() ? 0 : 1;
        return true;
    }
    return false;
}

Projection project_within(const SurfaceModel& model, const Vector3d& point, const SurfacePoint& start) {
    return Descent(model, point, start).run(tolerance_of(model));
}

Projection project_beyond(const ParametricSurface& surface, const Vector3d& point, const Vector2d& start) {
    return Descent(surface, point, start).run(0);
}

Projection project(const SurfaceModel& model, const Vector3d& point, const SurfacePoint& start) {
    constexpr int kMaxCrossings = 8;
    Projection best = project_within(model, point, start);
    for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
        bool improved = false;
        for (const SurfacePoint& way : ways_on(model, best.at, point)) {
            const Projection next = project_within(model, point, way);
            // Better by more than rounding, or two patches would hand the point to and fro.
            if (!(next.distance < best.distance * (1 - 1e-12))) continue;
            best = next;
            improved = true;
        }
        if (!improved) break;
    }
    return best;
}

/// A kd-tree over positions in an array: the middle of a range splits it.
class Locator::Samples {
  public:
    struct Sample {
        Vector3d point;
        SurfacePoint at;
    };

    Samples(const SurfaceModel& model, int intervals) {
        first_.push_back(0);
        for (int patch = 0; patch < model.num_patches(); ++patch) {
            for (const Vector2d& uv : model.samples(patch, intervals, intervals))
                by_patch_.push_back({model.position({patch, uv}), {patch, uv}});
            first_.push_back(by_patch_.size());
        }
        samples_ = by_patch_;
        axis_.resize(samples_.size());
        build(0, samples_.size());
    }

    std::span<const Sample> of_patch(int patch) const {
        return {by_patch_.data() + first_[patch], by_patch_.data() + first_[patch + 1]};
    }
    /// The nearest few, one per patch at most, nearest first.
    std::vector<SurfacePoint> near(const Vector3d& point, std::size_t count) const {
        std::vector<Found> found;
        search(0, samples_.size(), point, count, found);
        std::vector<SurfacePoint> places;
        for (const Found& f : found) places.push_back(samples_[f.sample].at);
        return places;
    }

  private:
    struct Found {
        double squared;
        std::size_t sample;
    };

    void build(std::size_t begin, std::size_t end) {
        if (begin >= end) return;
        Vector3d low = samples_[begin].point, high = low;
        for (std::size_t i = begin; i < end; ++i) {
            low = low.cwiseMin(samples_[i].point);
            high = high.cwiseMax(samples_[i].point);
        }
        int axis = 0;
        (high - low).maxCoeff(&axis);
        const std::size_t middle = begin + (end - begin) / 2;
        std::nth_element(samples_.begin() + begin, samples_.begin() + middle, samples_.begin() + end,
                         [&](const Sample& a, const Sample& b) { return a.point[axis] < b.point[axis]; });
        axis_[middle] = static_cast<char>(axis);
        build(begin, middle);
        build(middle + 1, end);
    }

    void search(std::size_t begin, std::size_t end, const Vector3d& point, std::size_t count,
                std::vector<Found>& found) const {
        if (begin >= end) return;
        const std::size_t middle = begin + (end - begin) / 2;
        keep({(samples_[middle].point - point).squaredNorm(), middle}, count, found);
        const double beyond = point[axis_[middle]] - samples_[middle].point[axis_[middle]];
        const auto lower = [&] { search(begin, middle, point, count, found); };
        const auto upper = [&] { search(middle + 1, end, point, count, found); };
        beyond < 0 ? lower() : upper();
        if (found.size() < count || beyond * beyond <= found.back().squared) beyond < 0 ? upper() : lower();
    }

    void keep(const Found& candidate, std::size_t count, std::vector<Found>& found) const {
        const auto same =
            std::find_if(found.begin(), found.end(), [&](const Found& f) { return patch(f) == patch(candidate); });
        if (same != found.end()) {
            if (candidate.squared >= same->squared) return;
            found.erase(same);
        }
        const auto nearer = [](const Found& a, const Found& b) { return a.squared < b.squared; };
        found.insert(std::upper_bound(found.begin(), found.end(), candidate, nearer), candidate);
        if (found.size() > count) found.pop_back();
    }

    int patch(const Found& f) const { return samples_[f.sample].at.patch; }

    std::vector<Sample> samples_, by_patch_;
    std::vector<std::size_t> first_;  // of each patch, in by_patch_
    std::vector<char> axis_;
};

Locator::Locator(const SurfaceModel& model, const LocateOptions& options) : model_(model), patches_(options.patches) {
    if (options.intervals < 1 || options.patches < 1)
        throw std::invalid_argument("locate: intervals " + std::to_string(options.intervals) + ", patches " +
                                    std::to_string(options.patches));
    const double share = std::min(1.0, static_cast<double>(SurfaceModel::kMany) / std::max(model.num_patches(), 1));
    samples_ = std::make_unique<const Samples>(
        model,
        std::max(std::min(options.intervals, 2), static_cast<int>(std::lround(options.intervals * std::sqrt(share)))));
}

Locator::~Locator() = default;

Projection Locator::find(const Vector3d& point) const {
    Projection best{{}, std::numeric_limits<double>::infinity()};
    if (!point.allFinite()) return best;
    for (const SurfacePoint& start : samples_->near(point, patches_)) {
        const Projection foot = project(model_, point, start);
        if (foot.distance < best.distance) best = foot;
    }
    return best;
}

Projection Locator::find_on(int patch, const Vector3d& point) const {
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (const Samples::Sample& sample : samples_->of_patch(patch)) {
        const double squared = (sample.point - point).squaredNorm();
        least = std::min(least, squared);
        most = std::max(most, squared);
    }
    // On a seam the same point is a start from either side, and only one of them may lead inside.
    Projection best{{}, std::numeric_limits<double>::infinity()};
    for (const Samples::Sample& sample : samples_->of_patch(patch)) {
        if ((sample.point - point).squaredNorm() > least + 1e-12 * most) continue;
        const Projection foot = project_within(model_, point, sample.at);
        if (foot.distance < best.distance) best = foot;
    }
    return best;
}

std::vector<SurfacePoint> locate(const SurfaceModel& model, std::span<const Vector3d> points,
                                 const LocateOptions& options) {
    const Locator locator(model, options);
    std::vector<SurfacePoint> places;
    places.reserve(points.size());
    for (const Vector3d& point : points) places.push_back(locator.find(point).at);
    return places;
}

}  // namespace gradus
