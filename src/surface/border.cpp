#include "border.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gradus {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

constexpr int kPieces = 8, kDeepest = 8;  // of a curve to begin with, and how often they are halved
constexpr double kFlat = 0.02;            // bulge over chord of a piece that is short enough
constexpr double kRounding = 1e-12;       // of the extent of the loops

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

AlignedBox2d grown(const AlignedBox2d& box, double by) {
    return {Vector2d(box.min().array() - by), Vector2d(box.max().array() + by)};
}

double distance_to_segment(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
    const Vector2d along = b - a;
    const double square = along.squaredNorm();
    const double s = square > 0 ? std::clamp(along.dot(p - a) / square, 0.0, 1.0) : 0;
    return (a + s * along - p).norm();
}

}  // namespace

SurfaceModel::Border::Border(const std::vector<std::vector<UseRef>>& loops, std::span<const ModelCurve> curves) {
    for (const std::vector<UseRef>& loop : loops)
        for (const UseRef& ref : loop) {
            const CurveUse& use = curves[ref.curve].uses[ref.use];
            Side side{ref, use.image.get(), use.reversed, use.image->uv(use.reversed ? 1 : 0), {0, 0}, 0, {}};
            const Vector2d along = use.image->uv(use.reversed ? 0 : 1) - side.start;
            side.outward = {along.y(), -along.x()};
            box_.extend(side.start);
            sides_.push_back(side);
        }
    convex_ = loops.size() == 1 && is_convex_polygon(sides_);
    if (convex_) return;
    for (Side& side : sides_) cut(side);
    for (const Side& side : sides_) box_.extend(side.box);
}

bool SurfaceModel::Border::is_convex_polygon(std::span<const Side> loop) const {
    if (loop.size() < 3) return false;
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Side &side = loop[k], &next = loop[(k + 1) % loop.size()];
        if (!side.image->is_straight() || !(cross(side.outward, next.outward) > 0)) return false;
    }
    // All turns are to the left; once around only.
    for (const Side& side : loop)
        for (const Side& other : loop)
            if (side.outward.dot(other.start - side.start) > kRounding * side.outward.norm() * box_.diagonal().norm())
                return false;
    return true;
}

// Halves pieces until they are nearly straight.
void SurfaceModel::Border::cut(Side& side) {
    side.first_piece = static_cast<int>(pieces_.size());
    const auto add = [&](auto&& self, double t0, const Vector2d& a, double t1, const Vector2d& b, int depth) -> void {
        const double t = (t0 + t1) / 2;
        const Vector2d middle = side.image->uv(t);
        const double bulge =
            std::max({distance_to_segment(middle, a, b), distance_to_segment(side.image->uv((3 * t0 + t1) / 4), a, b),
                      distance_to_segment(side.image->uv((t0 + 3 * t1) / 4), a, b)});
        if (depth > 0 && bulge > kFlat * (b - a).norm()) {
            self(self, t0, a, t, middle, depth - 1);
            self(self, t, middle, t1, b, depth - 1);
            return;
        }
        pieces_.push_back({t0, t1, a, b, 2 * bulge});
        side.box.extend(grown(AlignedBox2d(a).extend(b), 2 * bulge));
    };
    const int pieces = side.image->is_straight() ? 1 : kPieces;
    for (int k = 0; k < pieces; ++k) {
        const double t0 = static_cast<double>(k) / pieces, t1 = (k + 1.0) / pieces;
        add(add, t0, side.image->uv(t0), t1, side.image->uv(t1), side.image->is_straight() ? 0 : kDeepest);
    }
}

std::span<const SurfaceModel::Border::Piece> SurfaceModel::Border::pieces_of(std::size_t side) const {
    const std::size_t first = sides_[side].first_piece,
                      last = side + 1 < sides_.size() ? sides_[side + 1].first_piece : pieces_.size();
    return {pieces_.data() + first, last - first};
}

std::optional<SurfaceModel::Exit> SurfaceModel::Border::exit(const Vector2d& from, const Vector2d& step) const {
    return convex_ ? exit_polygon(from, step) : exit_curves(from, step);
}

std::optional<SurfaceModel::Exit> SurfaceModel::Border::exit_polygon(const Vector2d& from, const Vector2d& step) const {
    const Side* out = nullptr;
    double fraction = 1;
    for (const Side& side : sides_) {
        const double room = side.outward.dot(side.start - from), way = side.outward.dot(step);
        if (way > room && room < fraction * way) {
            fraction = std::max(0.0, room) / way;
            out = &side;
        }
    }
    if (!out) return std::nullopt;
    return Exit{fraction, out->use, out->image->parameter(from + fraction * step)};
}

std::optional<SurfaceModel::Exit> SurfaceModel::Border::exit_curves(const Vector2d& from, const Vector2d& step) const {
    const double rounding = kRounding * box_.diagonal().norm(), length = step.norm();
    if (!(length > 0)) return std::nullopt;
    const AlignedBox2d swept = grown(AlignedBox2d(from).extend(from + step), rounding);
    std::optional<Exit> first;
    for (std::size_t s = 0; s < sides_.size(); ++s) {
        const Side& side = sides_[s];
        if (!swept.intersects(side.box)) continue;
        for (const Piece& piece : pieces_of(s)) {
            if (!swept.intersects(grown(AlignedBox2d(piece.a).extend(piece.b), piece.bulge))) continue;
            // Newton's method on from + fraction step = image(t), from the crossing with the chord.
            double t = (piece.t0 + piece.t1) / 2, fraction = 0;
            bool found = false;
            for (int k = 0; k < 12 && !found; ++k) {
                const Vector2d along =
                                   k == 0 ? Vector2d((piece.b - piece.a) / (piece.t1 - piece.t0)) : side.image->duv(t),
                               at = k == 0 ? Vector2d((piece.a + piece.b) / 2) : side.image->uv(t);
                const double determinant = cross(step, along);
                if (std::abs(determinant) <= 1e-14 * length * along.norm()) break;
                fraction = cross(at - from, along) / determinant;
                const double move = cross(at - from, step) / determinant;
                t = std::clamp(t + move, 2 * piece.t0 - piece.t1, 2 * piece.t1 - piece.t0);
                found = k > 0 && std::abs(move) * along.norm() <= rounding;
            }
            const double slack = 1e-9 * (piece.t1 - piece.t0);
            if (!found || t < piece.t0 - slack || t > piece.t1 + slack) continue;
            const Vector2d along = side.reversed ? Vector2d(-side.image->duv(t)) : side.image->duv(t);
            // Only ways out: the patch is on the left of its loops.
            if (cross(along, step) >= 0 || fraction > 1 || fraction * length < -rounding) continue;
            if (!first || fraction < first->fraction)
                first = Exit{std::max(fraction, 0.0), side.use, std::clamp(t, 0.0, 1.0)};
        }
    }
    return first;
}

std::vector<SurfaceModel::OnBorder> SurfaceModel::Border::touching(const Vector2d& uv, double tolerance) const {
    std::vector<OnBorder> result;
    const double near = tolerance * box_.sizes().maxCoeff();
    for (const Side& side : sides_) {
        if (convex_ ? std::abs(side.outward.dot(uv - side.start)) > near * side.outward.norm()
                    : !grown(side.box, near).contains(uv))
            continue;
        const double t = side.image->parameter(uv);
        if (convex_ || (side.image->uv(t) - uv).norm() <= near) result.push_back({side.use, t});
    }
    return result;
}

bool SurfaceModel::Border::contains(const Vector2d& uv) const {
    const double rounding = kRounding * box_.diagonal().norm();
    if (convex_) {
        return std::all_of(sides_.begin(), sides_.end(), [&](const Side& side) {
            return side.outward.dot(uv - side.start) <= rounding * side.outward.norm();
        });
    }
    if (!grown(box_, rounding).contains(uv)) return false;
    bool inside = false;
    for (std::size_t s = 0; s < sides_.size(); ++s)
        for (const Piece& piece : pieces_of(s)) {
            // Beside a piece nearer than its chord can tell, its tangent tells.
            if (distance_to_segment(uv, piece.a, piece.b) <= piece.bulge + rounding) {
                const double t = sides_[s].image->parameter(uv);
                const Vector2d along = sides_[s].image->duv(t), away = uv - sides_[s].image->uv(t);
                return away.norm() <= rounding || (cross(along, away) > 0) != sides_[s].reversed;
            }
            if ((piece.a.y() > uv.y()) != (piece.b.y() > uv.y()) &&
                uv.x() <
                    piece.a.x() + (uv.y() - piece.a.y()) / (piece.b.y() - piece.a.y()) * (piece.b.x() - piece.a.x()))
                inside = !inside;
        }
    return inside;
}

}  // namespace gradus
