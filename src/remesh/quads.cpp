#include "gradus/remesh/quads.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
#include <queue>
#include <stdexcept>

#include "gradus/control/control_space.hpp"
#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/connectivity.hpp"
#include "gradus/mesh/frozen.hpp"
#include "matching.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

constexpr double kBadPair = 0.25;     // quality of quadrilaterals that two triangles are better than
constexpr long kWeightOfOne = 20000;  // of a quadrilateral, above that of its quality
constexpr double kWeightOfQuality = 10000;
constexpr int kSweeps = 12;           // of smoothing
constexpr int kMendings = 4;          // rounds of the topology
constexpr double kFlatCorner = 0.02;  // Jacobian ratio below which a corner counts as turned over
constexpr double kAreaWeight = 0.5;   // in the energy   // in the energy
constexpr double kKept = 0.2;         // quality that a change of the topology may leave, if it was not less before
constexpr int kNone = -1;

struct Polygon {
    std::array<int, 4> v{kNone, kNone, kNone, kNone};  // the last is kNone in triangles, the first in those removed
    int label = 0, part = 0;

    int size() const { return v[3] == kNone ? 3 : 4; }
    bool is_live() const { return v[0] != kNone; }
    int at(int k) const { return v[(k + size()) % size()]; }
    int find(int vertex) const {
        for (int k = 0; k < size(); ++k)
            if (v[k] == vertex) return k;
        return kNone;
    }
};

// Ratio of the Jacobian at a corner to the lengths of its two edges.
double corner_ratio(const Vector3d& a, const Vector3d& b, const Tensor* shape, const Vector3d& normal) {
    const double area = normal.dot(a.cross(b));
    const double la = shape ? squared_in(*shape, a) : a.squaredNorm(),
                 lb = shape ? squared_in(*shape, b) : b.squaredNorm();
    return la > 0 && lb > 0 ? area / std::sqrt(la * lb) : 0;
}

// The metric scaled to a determinant of one on the plane with this normal: lengths in it are to be compared with areas.
Tensor shape_of(const Tensor& metric, const Vector3d& normal) {
    return mean_square_size(size_tensor(metric), normal) * metric;
}

class Quadrangulation {
  public:
    Quadrangulation(const TriangleSoup& soup, const QuadOptions& options, QuadStatistics& statistics)
        : soup_(soup),
          options_(options),
          statistics_(statistics),
          mesh_(static_cast<int>(soup.points.size()), soup.triangles),
          points_(soup.points) {
        if (!options.metrics.empty() && options.metrics.size() != soup.points.size())
            throw std::invalid_argument("to_quads: " + std::to_string(options.metrics.size()) + " metrics for " +
                                        std::to_string(soup.points.size()) + " vertices");
        tag_what_stays();
        find_normals();
        find_parts();
    }

    QuadMesh run() {
        pair_triangles();
        if (options_.mode == QuadOptions::Mode::All) lead_triangles();
        smooth(kSweeps);
        for (int round = 0; round < kMendings && mend_topology(); ++round) smooth(kSweeps / 2);
        smooth(kSweeps);
        return options_.mode == QuadOptions::Mode::Refined ? refined(result()) : result();
    }

  private:
    // --- what the triangles say ---

    void tag_what_stays() {
        fixed_.assign(points_.size(), 0);
        const auto tag = [&](int h) {
            mesh_.set_tag(h, 0);
            fixed_[mesh_.origin(h)] = fixed_[mesh_.target(h)] = 1;
        };
        for (const auto& [a, b] : soup_.edges)
            if (const int h = mesh_.find_edge(a, b); h >= 0) tag(h);
        const auto label = [&](int t) { return soup_.labels.empty() ? 0 : soup_.labels[t]; };
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
            if (mesh_.twin(h) < 0 || label(h / 3) != label(mesh_.twin(h) / 3)) tag(h);
        const Frozen frozen = frozen_elements(points_, mesh_, soup_.required);
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
            if (frozen.has_edge(h)) tag(h);
        for (int v = 0; v < mesh_.num_vertices(); ++v)
            if (frozen.has_vertex(v)) fixed_[v] = 1;
        for (const int v : soup_.corners) fixed_[v] = 1;
        if (!frozen.empty())
            for (int t = 0; t < mesh_.num_triangles(); ++t)
                if (frozen.triangle[t]) required_triangles_.push_back(t);
    }

    void find_normals() {
        normals_.assign(points_.size(), Vector3d::Zero());
        for (const auto& [a, b, c] : soup_.triangles) {
            const Vector3d n = (points_[b] - points_[a]).cross(points_[c] - points_[a]);
            for (const int v : {a, b, c}) normals_[v] += n;
        }
        is_flat_ = true;
        for (std::size_t v = 0; v < points_.size(); ++v) {
            if (normals_[v].squaredNorm() > 0) normals_[v].normalize();
            is_flat_ = is_flat_ && points_[v].z() == 0;
        }
        find_areas();
        if (!options_.metrics.empty()) find_shapes();
        if (!is_flat_) closest_ = std::make_unique<ClosestTriangle>(soup_.points, soup_.triangles);
    }

    // Elements are to be as large as two of the triangles that were there.
    void find_areas() {
        areas_.assign(points_.size(), 0);
        std::vector<double> sides(points_.size(), 1);
        for (int v = 0; v < mesh_.num_vertices(); ++v) {
            cells_.push_back(mesh_.is_live_vertex(v) ? mesh_.outgoing(v) / 3 : 0);
            if (!mesh_.is_live_vertex(v)) continue;
            double sum = 0;
            int count = 0;
            mesh_.for_each_outgoing(v, [&](int h) {
                const Vector3d &a = points_[mesh_.target(h)], &b = points_[mesh_.apex(h)];
                sum += (a - points_[v]).cross(b - points_[v]).norm();
                ++count;
            });
            areas_[v] = sum / count;
            if (areas_[v] > 0) sides[v] = std::sqrt(areas_[v]);
        }
        sides_.emplace(points_, mesh_, sides);
    }

    void find_shapes() {
        std::vector<Tensor> sizes;
        for (const Tensor& metric : options_.metrics) sizes.push_back(size_tensor(metric));
        field_.emplace(points_, mesh_, sizes);
        shapes_.resize(points_.size());
        for (int v = 0; v < mesh_.num_vertices(); ++v) take_place(v);
    }

    // The area and the shape that are asked for where a vertex is.
    void take_place(int v) {
        const double side = sides_->size(points_[v], cells_[v]);
        areas_[v] = side * side;
        if (!field_) return;
        const Tensor size = field_->size(points_[v], cells_[v]);
        const Vector3d n = normals_[v].isZero() ? Vector3d::UnitZ().eval() : normals_[v];
        shapes_[v] = mean_square_size(size, n) * metric_of(size);
    }

    // Parts of the triangles, bounded by what pairs do not cross.
    void find_parts() {
        part_.assign(mesh_.num_triangles(), kNone);
        for (const int t : required_triangles_) part_[t] = num_parts_++;
        for (int first = 0; first < mesh_.num_triangles(); ++first) {
            if (part_[first] != kNone) continue;
            std::vector<int> list{first};
            part_[first] = num_parts_;
            for (std::size_t i = 0; i < list.size(); ++i)
                for (int h = 3 * list[i], end = h + 3; h < end; ++h)
                    if (mesh_.tag(h) < 0 && part_[mesh_.twin(h) / 3] == kNone)
                        part_[mesh_.twin(h) / 3] = num_parts_, list.push_back(mesh_.twin(h) / 3);
            statistics_.odd_parts += static_cast<int>(list.size() % 2);
            ++num_parts_;
        }
    }

    // --- quality ---

    const Tensor* mean_shape(std::span<const int> v, Tensor& room) const {
        if (shapes_.empty()) return nullptr;
        room = Tensor{};
        for (const int x : v) room = room + (1.0 / static_cast<double>(v.size())) * shapes_[x];
        return &room;
    }

    // The least ratio of a polygon's corners; of triangles over what an equilateral one has.
    double quality(const Polygon& p) const {
        Tensor room;
        const Tensor* shape = mean_shape(std::span(p.v).first(p.size()), room);
        double least = 1;
        for (int k = 0; k < p.size(); ++k) {
            const Vector3d &x = points_[p.v[k]], a = points_[p.at(k + 1)] - x, b = points_[p.at(k - 1)] - x;
            least =
                std::min(least, corner_ratio(a, b, shape, normals_[p.v[k]]) * (p.size() == 3 ? 2 / std::sqrt(3.0) : 1));
        }
        return least;
    }

    // What smoothing lowers: at each corner the mean square of its edges over their Jacobian, 1 for a square, squared;
    // a steep slope back where it is turned over.
    double energy(const Polygon& p) const {
        constexpr double kSteep = 1e4;
        Tensor room;
        const Tensor* shape = mean_shape(std::span(p.v).first(p.size()), room);
        double sum = 0;
        for (int k = 0; k < p.size(); ++k) {
            const Vector3d &x = points_[p.v[k]], a = points_[p.at(k + 1)] - x, b = points_[p.at(k - 1)] - x;
            const double la = shape ? squared_in(*shape, a) : a.squaredNorm(),
                         lb = shape ? squared_in(*shape, b) : b.squaredNorm();
            const double area = normals_[p.v[k]].dot(a.cross(b)), ratio = area / std::sqrt(std::max(la * lb, 1e-300));
            if (ratio < kFlatCorner) {
                sum += kSteep * (1 + kFlatCorner - ratio);
                continue;
            }
            const double uneven = (la + lb) / (2 * area);
            sum += uneven * uneven + 1 / (ratio * ratio);
        }
        return sum / p.size() + (p.size() == 4 ? kAreaWeight * area_term(p) : 0);
    }

    // 0 where a quadrilateral is as large as asked for.
    double area_term(const Polygon& p) const {
        double wanted = 0;
        Vector3d n = Vector3d::Zero();
        for (const int v : p.v) wanted += areas_[v] / 4, n += normals_[v];
        const double area =
            n.stableNormalized().dot((points_[p.v[2]] - points_[p.v[0]]).cross(points_[p.v[3]] - points_[p.v[1]])) / 2;
        const double m = std::max(area / wanted, 1e-3);
        return (m + 1 / m) / 2 - 1;
    }

    Polygon merged(int h) const {
        const int g = mesh_.twin(h);
        return {{mesh_.origin(h), mesh_.apex(g), mesh_.target(h), mesh_.apex(h)}};
    }

    // --- pairing ---

    void pair_triangles() {
        std::vector<std::array<int, 2>> edges;
        std::vector<long> weights;
        const bool all = options_.mode == QuadOptions::Mode::All;
        for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
            const int g = mesh_.twin(h);
            if (g < h || mesh_.tag(h) >= 0 || part_[h / 3] != part_[g / 3]) continue;
            const double q = quality(merged(h));
            if (!all && q < kBadPair) continue;
            edges.push_back({h / 3, g / 3});
            weights.push_back(std::max(1L, kWeightOfOne + std::lround(kWeightOfQuality * q)));
        }
        const std::vector<int> mate = detail::heaviest_matching(mesh_.num_triangles(), edges, weights);
        for (int t = 0; t < mesh_.num_triangles(); ++t) {
            const int label = soup_.labels.empty() ? 0 : soup_.labels[t];
            if (mate[t] < 0) {
                const auto [a, b, c] = mesh_.triangle(t);
                polygons_.push_back({{a, b, c, kNone}, label, part_[t]});
            } else if (t < mate[t]) {
                int h = 3 * t;
                while (mesh_.twin(h) < 0 || mesh_.twin(h) / 3 != mate[t]) ++h;
                Polygon quad = merged(h);
                quad.label = label;
                quad.part = part_[t];
                polygons_.push_back(quad);
                ++statistics_.paired;
            }
        }
        around_.assign(points_.size(), {});
        for (int p = 0; p < static_cast<int>(polygons_.size()); ++p) attach(p);
    }

    void attach(int p) {
        for (int k = 0; k < polygons_[p].size(); ++k) around_[polygons_[p].v[k]].push_back(p);
    }
    void detach(int p) {
        for (int k = 0; k < polygons_[p].size(); ++k) std::erase(around_[polygons_[p].v[k]], p);
    }
    void replace(int p, const std::array<int, 4>& v) {
        if (polygons_[p].is_live()) detach(p);
        polygons_[p].v = v;
        if (v[0] != kNone) attach(p);
    }

    // The polygon of the same part beyond an edge, or kNone.
    int beyond(int p, int a, int b) const {
        for (const int q : around_[a])
            if (q != p && polygons_[q].part == polygons_[p].part && polygons_[q].find(b) != kNone) {
                const int k = polygons_[q].find(b);
                if (polygons_[q].at(k + 1) == a && !is_feature(a, b)) return q;
            }
        return kNone;
    }
    bool is_feature(int a, int b) const {
        if (!fixed_[a] || !fixed_[b]) return false;
        const int h = mesh_.find_edge(a, b);
        return h >= 0 && mesh_.tag(h) >= 0;
    }

    // --- leading triangles to each other ---

    // From each triangle the shortest way over quadrilaterals to another one, which it then makes a quadrilateral with.
    void lead_triangles() {
        for (int p = 0; p < static_cast<int>(polygons_.size()); ++p)
            if (polygons_[p].is_live() && polygons_[p].size() == 3) lead(p);
    }

    void lead(int start) {
        std::map<int, int> came_from{{start, kNone}};
        std::queue<int> queue;
        queue.push(start);
        int goal = kNone;
        while (!queue.empty() && goal == kNone) {
            const int p = queue.front();
            queue.pop();
            for (int k = 0; k < polygons_[p].size() && goal == kNone; ++k) {
                const int q = beyond(p, polygons_[p].at(k), polygons_[p].at(k + 1));
                if (q == kNone || came_from.contains(q)) continue;
                came_from[q] = p;
                if (polygons_[q].size() == 3) goal = q;
                queue.push(q);
            }
        }
        if (goal == kNone) return;
        std::vector<int> path;
        for (int p = goal; p != kNone; p = came_from[p]) path.push_back(p);
        std::reverse(path.begin(), path.end());
        for (std::size_t i = 0; i + 1 < path.size(); ++i) {
            const int next = path[i + 1];
            if (polygons_[next].size() == 3)
                join(path[i], next);
            else
                step(path[i], next, path[i + 2]);
        }
        ++statistics_.led;
    }

    // The edge that two polygons share, as the first one has it.
    std::array<int, 2> shared(int p, int q) const {
        for (int k = 0; k < polygons_[p].size(); ++k) {
            const int a = polygons_[p].at(k), b = polygons_[p].at(k + 1);
            if (beyond(p, a, b) == q) return {a, b};
        }
        return {kNone, kNone};
    }

    // The outline of two polygons that share the edge (a, b), from b on.
    std::vector<int> outline(int p, int q, int a, int b) const {
        std::vector<int> v;
        for (int k = polygons_[p].find(b), i = 0; i < polygons_[p].size(); ++i) v.push_back(polygons_[p].at(k + i));
        for (int k = polygons_[q].find(a), i = 1; i + 1 < polygons_[q].size(); ++i) v.push_back(polygons_[q].at(k + i));
        return v;
    }

    void join(int p, int q) {
        const auto [a, b] = shared(p, q);
        const std::vector<int> v = outline(p, q, a, b);
        replace(q, {v[0], v[1], v[2], v[3]});
        replace(p, {kNone, kNone, kNone, kNone});
    }

    // A triangle p and a quadrilateral q become a quadrilateral p and a triangle q that is beside `next`.
    void step(int p, int q, int next) {
        const auto [c, d] = shared(q, next);
        const auto [a, b] = shared(p, q);
        const std::vector<int> v = outline(p, q, a, b);
        double best = -std::numeric_limits<double>::infinity();
        std::array<int, 4> quad{}, triangle{};
        for (int k = 0; k < 5; ++k) {
            const int before = v[(k + 4) % 5], corner = v[k], after = v[(k + 1) % 5];
            const bool has_edge = (before == c && corner == d) || (corner == c && after == d);
            if (!has_edge) continue;
            const Polygon one{{after, v[(k + 2) % 5], v[(k + 3) % 5], before}}, other{{before, corner, after, kNone}};
            const double worst = std::min(quality(one), quality(other));
            if (worst > best) best = worst, quad = one.v, triangle = other.v;
        }
        replace(p, quad);
        replace(q, triangle);
    }

    // --- positions ---

    Vector3d on_surface(int v, const Vector3d& target) const {
        if (is_flat_) return {target.x(), target.y(), 0};
        const auto hit = closest_->closest(target);
        const auto [a, b, c] = soup_.triangles[hit.triangle];
        static_cast<void>(v);
        return closest_point(target, soup_.points[a], soup_.points[b], soup_.points[c]);
    }

    double energy_around(int v) const {
        double sum = 0;
        for (const int p : around_[v]) sum += energy(polygons_[p]);
        return sum;
    }

    // Moves a vertex where the energy around it is least: along the axes of its shape, ever shorter steps.
    void relax(int v) {
        if (fixed_[v] || around_[v].empty()) return;
        const Vector3d& n = normals_[v];
        Vector3d u = n.unitOrthogonal(), w = n.cross(u);
        double length = 0;
        int count = 0;
        for (const int p : around_[v]) {
            const int k = polygons_[p].find(v);
            const Vector3d e = points_[polygons_[p].at(k + 1)] - points_[v];
            length += std::sqrt(shapes_.empty() ? e.squaredNorm() : squared_in(shapes_[v], e));
            ++count;
        }
        length /= count;
        if (!shapes_.empty()) {
            // Steps of one length in the shape, whatever their direction.
            const Axes axes = axes_of(shapes_[v]);
            int across = 0;
            for (int k = 1; k < 3; ++k)
                if (std::abs(axes.directions.col(k).dot(n)) > std::abs(axes.directions.col(across).dot(n))) across = k;
            u = axes.directions.col((across + 1) % 3) / std::sqrt(axes.values[(across + 1) % 3]);
            w = axes.directions.col((across + 2) % 3) / std::sqrt(axes.values[(across + 2) % 3]);
        }
        double least = energy_around(v);
        for (const double reach : {0.3, 0.1, 0.03}) {
            bool better = true;
            for (int tries = 0; better && tries < 3; ++tries) {
                better = false;
                const Vector3d from = points_[v];
                Vector3d best = from;
                for (int i = 0; i < 8; ++i) {
                    const double angle = i * 0.7853981633974483;
                    points_[v] = on_surface(v, from + reach * length * (std::cos(angle) * u + std::sin(angle) * w));
                    if (const double now = energy_around(v); now < least * (1 - 1e-6))
                        least = now, best = points_[v], better = true;
                }
                points_[v] = best;
            }
        }
        take_place(v);
    }

    void smooth(int sweeps) {
        for (int sweep = 0; sweep < sweeps; ++sweep)
            for (int v = 0; v < static_cast<int>(points_.size()); ++v) relax(v);
    }

    // --- topology ---

    int valence(int v) const { return static_cast<int>(around_[v].size()); }
    static int penalty(int valence) { return (valence - 4) * (valence - 4); }

    // Whether operations count the polygons of a vertex as its edges: all around it are quadrilaterals.
    bool is_inner(int v) const {
        return !fixed_[v] &&
               std::all_of(around_[v].begin(), around_[v].end(), [&](int p) { return polygons_[p].size() == 4; });
    }

    bool mend_topology() {
        int changes = 0;
        for (int p = 0; p < static_cast<int>(polygons_.size()); ++p) {
            if (!polygons_[p].is_live() || polygons_[p].size() != 4) continue;
            if (collapse(p)) ++changes, ++statistics_.collapses;
        }
        for (int p = 0; p < static_cast<int>(polygons_.size()); ++p)
            for (int k = 0; k < 4 && polygons_[p].is_live() && polygons_[p].size() == 4; ++k)
                if (rotate(p, k)) ++changes, ++statistics_.rotations;
        return changes > 0;
    }

    // What a change may undo: polygons and points.
    struct Saved {
        std::vector<std::pair<int, std::array<int, 4>>> polygons;
        std::vector<std::pair<int, Vector3d>> points;
    };
    void save(Saved& saved, std::span<const int> vertices) const {
        for (const int v : vertices) {
            saved.points.emplace_back(v, points_[v]);
            for (const int p : around_[v]) saved.polygons.emplace_back(p, polygons_[p].v);
        }
    }
    void restore(const Saved& saved) {
        for (const auto& [p, v] : saved.polygons) replace(p, {kNone, kNone, kNone, kNone});
        std::map<int, std::array<int, 4>> once(saved.polygons.begin(), saved.polygons.end());
        for (const auto& [p, v] : once) {
            polygons_[p].v = v;
            attach(p);
        }
        for (const auto& [v, p] : saved.points) points_[v] = p;
    }

    double worst_around(std::span<const int> vertices) const {
        double worst = 1;
        for (const int v : vertices)
            for (const int p : around_[v]) worst = std::min(worst, quality(polygons_[p]));
        return worst;
    }

    // Keeps a change of the topology where, once what is around has settled, no polygon is bad.
    bool settle(const Saved& saved, std::span<const int> vertices, double before) {
        for (int round = 0; round < 3; ++round)
            for (const int v : vertices) relax(v);
        if (worst_around(vertices) >= std::min(before, kKept)) return true;
        restore(saved);
        return false;
    }

    // Takes a quadrilateral away by making one vertex of two that are opposite in it: doublets, where one of them has
    // only two polygons, and diamonds.
    bool collapse(int p) {
        for (const int k : {0, 1}) {
            const Polygon quad = polygons_[p];
            const int a = quad.at(k), b = quad.at(k + 1), c = quad.at(k + 2), d = quad.at(k + 3);
            if (!is_inner(a) || !(is_inner(c) || fixed_[c])) continue;
            if (!is_inner(b) || !is_inner(d)) continue;
            if (valence(b) < 4 || valence(d) < 4) {
                if (valence(a) > 2 && valence(c) > 2) continue;
                if (valence(b) < 3 || valence(d) < 3) continue;
            }
            const int before =
                penalty(valence(a)) + (fixed_[c] ? 0 : penalty(valence(c))) + penalty(valence(b)) + penalty(valence(d));
            const int after = (fixed_[c] ? 0 : penalty(valence(a) + valence(c) - 2)) + penalty(valence(b) - 1) +
                              penalty(valence(d) - 1);
            if (after >= before || (fixed_[c] && valence(a) > 2)) continue;
            if (share_polygon(a, c, p)) continue;
            const std::array<int, 4> all{a, b, c, d};
            const double worst = worst_around(all);
            Saved saved;
            save(saved, all);
            if (!fixed_[c]) points_[c] = on_surface(c, (points_[a] + points_[c]) / 2);
            replace(p, {kNone, kNone, kNone, kNone});
            const std::vector<int> of_a = around_[a];
            for (const int q : of_a) {
                std::array<int, 4> v = polygons_[q].v;
                std::replace(v.begin(), v.end(), a, c);
                replace(q, v);
            }
            const std::array<int, 3> left{c, b, d};
            if (settle(saved, left, worst)) return true;
        }
        return false;
    }

    // Whether two vertices are in one polygon other than p, or joined to one vertex beside those of p.
    bool share_polygon(int a, int c, int p) const {
        for (const int q : around_[a])
            if (q != p && polygons_[q].find(c) != kNone) return true;
        int common = 0;
        const auto neighbours = [&](int v) {
            std::vector<int> list;
            for (const int q : around_[v]) {
                const int k = polygons_[q].find(v);
                list.push_back(polygons_[q].at(k + 1));
                list.push_back(polygons_[q].at(k - 1));
            }
            std::sort(list.begin(), list.end());
            list.erase(std::unique(list.begin(), list.end()), list.end());
            return list;
        };
        const std::vector<int> of_a = neighbours(a), of_c = neighbours(c);
        for (const int v : of_a) common += std::binary_search(of_c.begin(), of_c.end(), v);
        return common > 2;
    }

    // Turns the edge between two quadrilaterals on, one way or the other, where that makes valences better.
    bool rotate(int p, int k) {
        const int a = polygons_[p].at(k), b = polygons_[p].at(k + 1), q = beyond(p, a, b);
        if (q == kNone || polygons_[q].size() != 4) return false;
        const std::vector<int> v = outline(p, q, a, b);  // b x y a z w
        if (std::any_of(v.begin(), v.end(), [&](int x) { return std::count(v.begin(), v.end(), x) > 1; })) return false;
        const auto cost = [&](int x, int by) { return fixed_[x] ? 0 : penalty(valence(x) + by); };
        if (!fixed_[a] && valence(a) < 4 && !fixed_[b] && valence(b) < 4) return false;
        for (const int turn : {1, 2}) {
            const int from = v[turn], to = v[turn + 3];
            const int before = cost(a, 0) + cost(b, 0) + cost(from, 0) + cost(to, 0);
            const int after = cost(a, -1) + cost(b, -1) + cost(from, 1) + cost(to, 1);
            if (after >= before || valence(a) < 3 || valence(b) < 3) continue;
            const double worst = worst_around(v);
            Saved saved;
            save(saved, v);
            const auto at = [&](int i) { return v[(turn + i) % 6]; };
            replace(p, {at(0), at(1), at(2), at(3)});
            replace(q, {at(3), at(4), at(5), at(0)});
            if (settle(saved, v, worst)) return true;
        }
        return false;
    }

    // --- the result ---

    QuadMesh result() const {
        QuadMesh mesh;
        mesh.dimension = soup_.dimension;
        std::vector<int> number(points_.size(), kNone);
        for (std::size_t v = 0; v < points_.size(); ++v) {
            if (around_[v].empty()) continue;
            number[v] = static_cast<int>(mesh.points.size());
            mesh.points.push_back(points_[v]);
        }
        for (const Polygon& p : polygons_) {
            if (!p.is_live()) continue;
            if (p.size() == 4) {
                mesh.quads.push_back({number[p.v[0]], number[p.v[1]], number[p.v[2]], number[p.v[3]]});
                mesh.quad_labels.push_back(p.label);
            } else {
                mesh.triangles.push_back({number[p.v[0]], number[p.v[1]], number[p.v[2]]});
                mesh.triangle_labels.push_back(p.label);
            }
        }
        if (soup_.labels.empty()) mesh.quad_labels.clear(), mesh.triangle_labels.clear();
        for (const auto& [a, b] : soup_.edges) mesh.edges.push_back({number[a], number[b]});
        mesh.edge_labels = soup_.edge_labels;
        for (const int v : soup_.corners) mesh.corners.push_back(number[v]);
        if (field_) {
            for (std::size_t v = 0; v < points_.size(); ++v) {
                int cell = cells_[v];
                if (number[v] != kNone) mesh.metrics.push_back(metric_of(field_->size(points_[v], cell)));
            }
        }
        return mesh;
    }

    // Every edge halved, every polygon divided from its middle.
    QuadMesh refined(const QuadMesh& coarse) const {
        QuadMesh mesh;
        mesh.points = coarse.points;
        mesh.dimension = coarse.dimension;
        mesh.corners = coarse.corners;
        std::map<std::array<int, 2>, int> middles;
        const auto add = [&](const Vector3d& p) {
            mesh.points.push_back(on_surface(0, p));
            return static_cast<int>(mesh.points.size()) - 1;
        };
        const auto middle = [&](int a, int b) {
            const auto [at, fresh] = middles.try_emplace({std::min(a, b), std::max(a, b)}, 0);
            if (fresh) at->second = add((mesh.points[a] + mesh.points[b]) / 2);
            return at->second;
        };
        const auto divide = [&](std::span<const int> v, std::optional<int> label) {
            Vector3d sum = Vector3d::Zero();
            for (const int x : v) sum += mesh.points[x];
            const int centre = add(sum / static_cast<double>(v.size())), n = static_cast<int>(v.size());
            for (int k = 0; k < n; ++k) {
                mesh.quads.push_back({v[k], middle(v[k], v[(k + 1) % n]), centre, middle(v[(k + n - 1) % n], v[k])});
                if (label) mesh.quad_labels.push_back(*label);
            }
        };
        const auto label_of = [](const std::vector<int>& labels, std::size_t i) {
            return labels.empty() ? std::nullopt : std::optional(labels[i]);
        };
        for (std::size_t i = 0; i < coarse.quads.size(); ++i) divide(coarse.quads[i], label_of(coarse.quad_labels, i));
        for (std::size_t i = 0; i < coarse.triangles.size(); ++i)
            divide(coarse.triangles[i], label_of(coarse.triangle_labels, i));
        for (std::size_t i = 0; i < coarse.edges.size(); ++i) {
            const auto [a, b] = coarse.edges[i];
            mesh.edges.push_back({a, middle(a, b)});
            mesh.edges.push_back({middle(a, b), b});
            if (!coarse.edge_labels.empty()) mesh.edge_labels.insert(mesh.edge_labels.end(), 2, coarse.edge_labels[i]);
        }
        return mesh;
    }

    const TriangleSoup& soup_;
    const QuadOptions& options_;
    QuadStatistics& statistics_;
    Connectivity mesh_;
    std::vector<Vector3d> points_, normals_;
    std::optional<ControlSpace> sides_;  // square roots of areas
    std::vector<double> areas_;          // asked for at the vertices
    std::optional<TensorSpace> field_;   // of the metrics
    std::vector<int> cells_;             // triangles of it at the vertices
    std::vector<Tensor> shapes_;         // of the metrics, or empty
    std::vector<char> fixed_;
    std::vector<int> part_, required_triangles_;
    int num_parts_ = 0;
    bool is_flat_ = false;
    std::unique_ptr<ClosestTriangle> closest_;
    std::vector<Polygon> polygons_;
    std::vector<std::vector<int>> around_;  // polygons at each vertex
};

}  // namespace

double quad_quality(const std::array<Vector3d, 4>& corners, const Vector3d& normal) {
    double least = 1;
    for (int k = 0; k < 4; ++k)
        least = std::min(
            least, corner_ratio(corners[(k + 1) % 4] - corners[k], corners[(k + 3) % 4] - corners[k], nullptr, normal));
    return least;
}

double quad_quality(const std::array<Vector3d, 4>& corners, const std::array<Tensor, 4>& metrics,
                    const Vector3d& normal) {
    Tensor mean;
    for (const Tensor& m : metrics) mean = mean + 0.25 * shape_of(m, normal);
    // The mean of shapes is less than one where they differ: what counts is the Jacobian in it.
    const double root = 1 / mean_square_size(size_tensor(mean), normal);
    double least = 1;
    for (int k = 0; k < 4; ++k)
        least = std::min(least, root * corner_ratio(corners[(k + 1) % 4] - corners[k],
                                                    corners[(k + 3) % 4] - corners[k], &mean, normal));
    return least;
}

QuadMesh to_quads(const TriangleSoup& soup, const QuadOptions& options, QuadStatistics* statistics) {
    QuadStatistics own;
    return Quadrangulation(soup, options, statistics ? *statistics : own).run();
}

}  // namespace gradus
