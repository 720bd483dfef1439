#include "gradus/quality/project.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

namespace gradus {

namespace {

// Parameters this near a side, relative to the domain, lie on it: shared places are computed by affine maps.
constexpr double kOnSide = 1e-10;

double side_value(const Domain& domain, Side side) {
    switch (side) {
        case Side::Bottom:
            return domain.min[1];
        case Side::Right:
            return domain.max[0];
        case Side::Top:
            return domain.max[1];
        default:
            return domain.min[0];
    }
}

/// Parameter that varies along a side (0: u, 1: v).
int along_side(Side side) { return along_u(side) ? 0 : 1; }

bool on_side(const Domain& domain, const Eigen::Vector2d& uv, Side side) {
    const int across = 1 - along_side(side);
    return std::abs(uv[across] - side_value(domain, side)) <= kOnSide * (domain.max[across] - domain.min[across]);
}

constexpr std::array<Side, 4> kSides{Side::Bottom, Side::Right, Side::Top, Side::Left};

bool on_any_side(const Domain& domain, const Eigen::Vector2d& uv) {
    return on_side(domain, uv, Side::Bottom) || on_side(domain, uv, Side::Right) || on_side(domain, uv, Side::Top) ||
           on_side(domain, uv, Side::Left);
}

std::vector<Side> sides_at(const Domain& domain, const Eigen::Vector2d& uv) {
    std::vector<Side> sides;
    for (const Side side : kSides)
        if (on_side(domain, uv, side)) sides.push_back(side);
    return sides;
}

bool collapsed(const PatchModel& model, int patch, Side side) {
    const int curve = model.side_curve(patch, side).curve;
    return curve >= 0 && model.curves()[curve].kind == CurveKind::Pole;
}

int corner_at(const Domain& domain, const Eigen::Vector2d& uv) {
    const bool right = on_side(domain, uv, Side::Right), top = on_side(domain, uv, Side::Top);
    return top ? (right ? 2 : 3) : (right ? 1 : 0);
}

/// Half the squared distance to a point as a function of the parameters, to second order.
struct Objective {
    double value;
    Eigen::Vector2d gradient;
    Eigen::Matrix2d first_form, hessian;

    Objective(const ParametricSurface& surface, const Eigen::Vector2d& uv, const Eigen::Vector3d& point) {
        const Jet2 jet = surface.jet2(uv);
        const Eigen::Vector3d r = jet.p - point;
        value = r.squaredNorm() / 2;
        gradient = {r.dot(jet.du), r.dot(jet.dv)};
        first_form << jet.du.squaredNorm(), jet.du.dot(jet.dv), jet.du.dot(jet.dv), jet.dv.squaredNorm();
        hessian << r.dot(jet.duu), r.dot(jet.duv), r.dot(jet.duv), r.dot(jet.dvv);
        hessian += first_form;
    }
};

/// Newton step of the free parameters; by the first form alone (Gauss-Newton) where the Hessian is no safe guide.
Eigen::Vector2d newton_step(const Objective& f, const std::array<bool, 2>& free) {
    constexpr double kSafe = 1e-2;  // part of the first form that the Hessian must keep
    constexpr double kSingular =
        1e-24;  // squared sine, or squared ratio of speeds, below which a direction is left alone
    const double scale = f.first_form.trace();
    Eigen::Vector2d step(0, 0);
    if (free[0] && free[1] && f.first_form.determinant() > kSingular * scale * scale) {
        const bool safe = f.hessian.determinant() > kSafe * f.first_form.determinant() &&
                          f.hessian(0, 0) > kSafe * f.first_form(0, 0);
        const Eigen::Matrix2d& m = safe ? f.hessian : f.first_form;
        step = -Eigen::Vector2d(m(1, 1) * f.gradient[0] - m(0, 1) * f.gradient[1],
                                m(0, 0) * f.gradient[1] - m(1, 0) * f.gradient[0]) /
               m.determinant();
        return step;
    }
    // One parameter at a time: the faster of the free ones.
    const int k = free[0] && (!free[1] || f.first_form(0, 0) >= f.first_form(1, 1)) ? 0 : 1;
    const double speed = f.first_form(k, k);
    if (!free[k] || !(speed > kSingular * scale)) return step;
    step[k] = -f.gradient[k] / (f.hessian(k, k) > kSafe * speed ? f.hessian(k, k) : speed);
    return step;
}

struct Foot {
    Eigen::Vector2d uv;
    double value;  // half the squared distance
};

/// Local minimum of the distance over one patch.
Foot descend(const ParametricSurface& surface, const Domain& domain, const Eigen::Vector3d& point,
             const Eigen::Vector2d& start, double tolerance) {
    constexpr int kMaxSteps = 30, kMaxHalvings = 12;
    Eigen::Vector2d uv = start.cwiseMax(domain.min).cwiseMin(domain.max);
    Objective f(surface, uv, point);
    for (int i = 0; i < kMaxSteps; ++i) {
        std::array<bool, 2> free;
        for (int k = 0; k < 2; ++k)
            free[k] =
                !(uv[k] <= domain.min[k] && f.gradient[k] >= 0) && !(uv[k] >= domain.max[k] && f.gradient[k] <= 0);
        Eigen::Vector2d step = newton_step(f, free);
        const double length = std::sqrt(std::max(0.0, step.dot(f.first_form * step)));
        bool improved = false;
        for (int half = 0; half < kMaxHalvings && !improved; ++half, step /= 2) {
            const Eigen::Vector2d next_uv = (uv + step).cwiseMax(domain.min).cwiseMin(domain.max);
            if (next_uv == uv) break;
            const Objective next(surface, next_uv, point);
            if (!(next.value < f.value)) continue;
            uv = next_uv;
            f = next;
            improved = true;
        }
        // A step this short was one of quadratic convergence: what remains is its square.
        if (!improved || length < tolerance) break;
    }
    return {uv, f.value};
}

/// A start away from a collapsed side, in the direction along it that leads nearest to the point.
std::optional<SurfacePoint> leave_pole(const PatchModel& model, int patch, Side side, const Eigen::Vector3d& point) {
    constexpr int kDirections = 16;
    const ParametricSurface& surface = model.patch(patch);
    const Domain domain = surface.domain();
    const int along = along_side(side), across = 1 - along;
    const double inward = side == Side::Bottom || side == Side::Left ? 1 : -1;
    std::optional<SurfacePoint> best;
    double best_gain = 0;
    for (int i = 0; i < kDirections; ++i) {
        Eigen::Vector2d uv;
        uv[across] = side_value(domain, side);
        uv[along] = domain.min[along] + (i + .5) / kDirections * (domain.max[along] - domain.min[along]);
        const Jet1 jet = surface.jet1(uv);
        const Eigen::Vector3d direction = inward * (across == 0 ? jet.du : jet.dv);
        const double gain = direction.dot(point - jet.p), speed = direction.squaredNorm();
        if (!(speed > 0) || gain <= best_gain * std::sqrt(speed)) continue;
        best_gain = gain / std::sqrt(speed);
        uv[across] += inward * gain / speed;
        best = SurfacePoint{patch, uv};
    }
    return best;
}

/// Where to go on from a foot on the border of its patch.
std::vector<SurfacePoint> ways_on(const PatchModel& model, const SurfacePoint& at, const Eigen::Vector3d& point) {
    std::vector<SurfacePoint> starts;
    if (!on_any_side(model.patch(at.patch).domain(), at.uv)) return starts;
    for (const SurfacePoint& place : places_of(model, at)) {
        bool pole = false;
        for (const Side side : sides_at(model.patch(place.patch).domain(), place.uv)) {
            if (!collapsed(model, place.patch, side)) continue;
            pole = true;
            if (const auto start = leave_pole(model, place.patch, side, point)) starts.push_back(*start);
        }
        if (!pole && !(place.patch == at.patch && place.uv == at.uv)) starts.push_back(place);
    }
    return starts;
}

/// Nearest of a fixed set of points, by a kd-tree over positions in an array: the middle of a range splits it.
class NearestSamples {
  public:
    struct Sample {
        Eigen::Vector3d point;
        SurfacePoint at;
    };

    explicit NearestSamples(std::vector<Sample> samples) : samples_(std::move(samples)), axis_(samples_.size()) {
        build(0, samples_.size());
    }

    /// The nearest few, one per patch at most, nearest first.
    std::vector<SurfacePoint> near(const Eigen::Vector3d& point, std::size_t count) const {
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
        Eigen::Vector3d low = samples_[begin].point, high = low;
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

    void search(std::size_t begin, std::size_t end, const Eigen::Vector3d& point, std::size_t count,
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

    std::vector<Sample> samples_;
    std::vector<char> axis_;
};

NearestSamples sample_model(const PatchModel& model, int intervals) {
    std::vector<NearestSamples::Sample> samples;
    samples.reserve(static_cast<std::size_t>(model.num_patches()) * (intervals + 1) * (intervals + 1));
    for (int patch = 0; patch < model.num_patches(); ++patch) {
        const Domain domain = model.patch(patch).domain();
        for (int j = 0; j <= intervals; ++j)
            for (int i = 0; i <= intervals; ++i) {
                const Eigen::Vector2d part(static_cast<double>(i) / intervals, static_cast<double>(j) / intervals);
                const SurfacePoint at{patch, domain.min + part.cwiseProduct(domain.max - domain.min)};
                samples.push_back({model.position(at), at});
            }
    }
    return NearestSamples(std::move(samples));
}

}  // namespace

std::vector<SurfacePoint> places_of(const PatchModel& model, const SurfacePoint& at) {
    std::vector<SurfacePoint> places{at};
    const Domain domain = model.patch(at.patch).domain();
    const std::vector<Side> sides = sides_at(domain, at.uv);
    if (sides.empty()) return places;

    const auto add_vertex = [&](int vertex) {
        for (const SurfacePoint& place : model.vertices()[vertex].places)
            if (place.patch != at.patch || !place.uv.isApprox(at.uv, kOnSide)) places.push_back(place);
    };
    if (sides.size() > 1) {
        add_vertex(model.corner_vertex(at.patch, corner_at(domain, at.uv)));
        return places;
    }
    const auto [curve_index, use] = model.side_curve(at.patch, sides[0]);
    if (curve_index < 0) return places;
    const ModelCurve& curve = model.curves()[curve_index];
    if (curve.kind == CurveKind::Pole) {
        add_vertex(curve.ends[0]);
        return places;
    }
    const int along = along_side(sides[0]);
    const double s = (at.uv[along] - domain.min[along]) / (domain.max[along] - domain.min[along]);
    const double t = model.curve_parameter(at.patch, sides[0], std::clamp(s, 0.0, 1.0));
    for (int other = 0; other < static_cast<int>(curve.uses.size()); ++other)
        if (other != use) places.push_back(model.on_curve(curve_index, other, t));
    return places;
}

bool on_pole(const PatchModel& model, const SurfacePoint& at, int& along) {
    const Domain domain = model.patch(at.patch).domain();
    if (!on_any_side(domain, at.uv)) return false;
    for (const Side side : sides_at(domain, at.uv)) {
        if (!collapsed(model, at.patch, side)) continue;
        along = along_side(side);
        return true;
    }
    return false;
}

Projection project(const PatchModel& model, const Eigen::Vector3d& point, const SurfacePoint& start) {
    constexpr int kMaxCrossings = 8;
    const double tolerance = 1e-9 * model.diagonal();
    const auto descend_from = [&](const SurfacePoint& from) {
        const ParametricSurface& surface = model.patch(from.patch);
        return descend(surface, surface.domain(), point, from.uv, tolerance);
    };
    SurfacePoint at = start;
    Foot foot = descend_from(start);
    at.uv = foot.uv;
    for (int crossing = 0; crossing < kMaxCrossings; ++crossing) {
        bool improved = false;
        for (const SurfacePoint& way : ways_on(model, at, point)) {
            const Foot next = descend_from(way);
            // Better by more than rounding, or two patches would hand the point to and fro.
            if (!(next.value < foot.value * (1 - 1e-12))) continue;
            foot = next;
            at = {way.patch, next.uv};
            improved = true;
        }
        if (!improved) break;
    }
    return {at, std::sqrt(2 * foot.value)};
}

std::vector<SurfacePoint> locate(const PatchModel& model, std::span<const Eigen::Vector3d> points,
                                 const LocateOptions& options) {
    if (options.intervals < 1 || options.patches < 1)
        throw std::invalid_argument("locate: intervals " + std::to_string(options.intervals) + ", patches " +
                                    std::to_string(options.patches));
    const NearestSamples samples = sample_model(model, options.intervals);
    std::vector<SurfacePoint> places;
    places.reserve(points.size());
    for (const Eigen::Vector3d& point : points) {
        Projection best;
        best.distance = std::numeric_limits<double>::infinity();
        for (const SurfacePoint& start : samples.near(point, options.patches)) {
            const Projection foot = project(model, point, start);
            if (foot.distance < best.distance) best = foot;
        }
        places.push_back(best.at);
    }
    return places;
}

}  // namespace gradus
