#include "polygons.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "gradus/io/error.hpp"

namespace gradus::io {

namespace {

using Eigen::Vector3d;

constexpr double kGoodShape = 0.15;                           // of an ear that is taken at once; .29 is equilateral
constexpr std::size_t kCornersTold = 12, kMostSides = 2'000;  // of a face that are looked at for crossings
constexpr double kRounding = 1e-9;                            // of the longer side: nearer to each other sides meet
constexpr std::size_t kMostWork =
    200'000'000;  // corners looked at in a file: fans that are left then stay, seconds later

class Clipper {
  public:
    Clipper(const TriangleSoup& soup, std::vector<int> loop)
        : soup_(soup), loop_(std::move(loop)), normal_(Vector3d::Zero()) {
        for (std::size_t i = 0; i < loop_.size(); ++i) normal_ += (at(i) - at(0)).cross(at(i + 1) - at(0));
        normal_ = normal_.stableNormalized();
    }

    bool is_convex() const {
        for (std::size_t i = 0; i < loop_.size(); ++i)
            if (turn(loop_[i], next(i), next(i + 1)) < 0) return false;
        return true;
    }

    // Empty where there is no ear.
    std::vector<Triangle> clip(std::size_t& work) {
        std::vector<Triangle> triangles;
        while (loop_.size() > 3) {
            std::size_t best = loop_.size();
            double best_shape = 0;
            for (std::size_t i = 0; i < loop_.size() && best_shape < kGoodShape && work < kMostWork; ++i) {
                work += loop_.size();
                if (const double shape = ear_shape(i); shape > best_shape) best = i, best_shape = shape;
            }
            if (best == loop_.size() || work >= kMostWork) return {};
            triangles.push_back({previous(best), loop_[best], next(best)});
            loop_.erase(loop_.begin() + static_cast<std::ptrdiff_t>(best));
        }
        triangles.push_back({loop_[0], loop_[1], loop_[2]});
        return triangles;
    }

  private:
    const Vector3d& at(std::size_t i) const { return soup_.points[loop_[i % loop_.size()]]; }
    int next(std::size_t i) const { return loop_[(i + 1) % loop_.size()]; }
    int previous(std::size_t i) const { return loop_[(i + loop_.size() - 1) % loop_.size()]; }
    // Twice the area of a triangle as it is seen along the normal.
    double turn(int a, int b, int c) const {
        const Vector3d &p = soup_.points[a], &q = soup_.points[b], &r = soup_.points[c];
        return normal_.dot((q - p).cross(r - p));
    }

    // Of the triangle at a corner, its area over the squares of its sides; 0 where it is no ear.
    double ear_shape(std::size_t i) const {
        const int a = previous(i), b = loop_[i], c = next(i);
        const double area = turn(a, b, c);
        if (!(area > 0)) return 0;
        for (const int v : loop_) {
            if (v == a || v == b || v == c) continue;
            if (turn(a, b, v) >= 0 && turn(b, c, v) >= 0 && turn(c, a, v) >= 0) return 0;
        }
        const Vector3d &p = soup_.points[a], &q = soup_.points[b], &r = soup_.points[c];
        return area / ((q - p).squaredNorm() + (r - q).squaredNorm() + (p - r).squaredNorm());
    }

    const TriangleSoup& soup_;
    std::vector<int> loop_;
    Vector3d normal_;
};

// Whether two segments have a point in common, each inside.
bool cross(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
    const Vector3d u = b - a, v = d - c, w = c - a, normal = u.cross(v);
    const double length2 = std::max(u.squaredNorm(), v.squaredNorm());
    if (!(normal.squaredNorm() > kRounding * kRounding * length2 * length2)) return false;
    const double s = w.cross(v).dot(normal) / normal.squaredNorm(), t = w.cross(u).dot(normal) / normal.squaredNorm();
    return s > 0 && s < 1 && t > 0 && t < 1 && std::abs(w.dot(normal.normalized())) <= kRounding * std::sqrt(length2);
}

bool crosses_itself(const TriangleSoup& soup, const std::vector<int>& loop) {
    const auto at = [&](std::size_t i) -> const Vector3d& { return soup.points[loop[i % loop.size()]]; };
    for (std::size_t i = 0; i + 2 < std::min(loop.size(), kMostSides); ++i)
        for (std::size_t j = i + 2; j < loop.size(); ++j)
            if (cross(at(i), at(i + 1), at(j), at(j + 1))) return true;
    return false;
}

}  // namespace

void clip_ears(const std::string& path, TriangleSoup& soup, const std::vector<Fan>& fans) {
    std::size_t work = 0;
    for (const Fan& fan : fans) {
        std::vector<int> loop{soup.triangles[fan.first][0], soup.triangles[fan.first][1]};
        for (std::size_t t = fan.first; t < fan.first + fan.triangles; ++t) loop.push_back(soup.triangles[t][2]);
        Clipper clipper(soup, loop);
        if (clipper.is_convex()) continue;
        if (crosses_itself(soup, loop)) {
            loop.resize(std::min(loop.size(), kCornersTold));
            throw IoError(
                path, 0,
                fmt::format("the face with the vertices {} (counted from 0) crosses itself", fmt::join(loop, " ")));
        }
        const std::vector<Triangle> ears = clipper.clip(work);
        if (ears.size() == fan.triangles)
            std::copy(ears.begin(), ears.end(), soup.triangles.begin() + static_cast<std::ptrdiff_t>(fan.first));
    }
}

}  // namespace gradus::io
