#include "gradus/control/geometric_size.hpp"

#include "gradus/control/metric.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/mesh/connectivity.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>

namespace gradus {

namespace {

constexpr int kMostPieces = 20000;     // of a curve to begin with: patches up to 40 000 times as long as wide
constexpr double kLeastAspect = 0.15;  // height over longest edge below which a triangle is a needle worth cutting

// Radius of curvature of a curve; infinite where it is straight or stands still.
double curve_radius(const SurfaceModel& model, int curve, double t) {
    const CurveJet2 jet = model.curve_jet2(curve, t);
    const double speed = jet.d.norm(), turn = jet.d.cross(jet.dd).norm();
    return turn > 1e-12 * speed * speed * speed / model.diagonal() ? speed * speed * speed / turn
                                                                   : std::numeric_limits<double>::infinity();
}

// Size by the curvature of the patch, and of the features it lies on.
double size_at(const SurfaceModel& model, const SizingRule& rule, const SurfacePoint& at) {
    double h = size_from_radius(rule, minimal_radius(model.patch(at.patch), at.uv));
    for (const auto& [use, t] : model.border_at(at))
        if (is_feature(model.curves()[use.curve].kind))
            h = std::min(h, size_from_radius(rule, curve_radius(model, use.curve, t)));
    return h;
}

// Largest length of three parameter lines of a patch in direction `along`.
double extent_of(const ParametricSurface& patch, int along, int steps) {
    const Domain d = patch.domain();
    double longest = 0;
    for (const double across : {0.0, 0.5, 1.0}) {
        double length = 0;
        Eigen::Vector3d last;
        for (int i = 0; i <= steps; ++i) {
            Eigen::Vector2d s;
            s[along] = static_cast<double>(i) / steps;
            s[1 - along] = across;
            const Eigen::Vector3d p = patch.position(d.min + s.cwiseProduct(d.max - d.min));
            if (i > 0) length += (p - last).norm();
            last = p;
        }
        longest = std::max(longest, length);
    }
    return longest;
}

// How many pieces each curve starts with. Opposite sides of a patch have the same number, so the classes of curves that
// are opposite to each other share the largest number any patch asks for. Squares are at most kLongSquare times as long
// as wide: bisection of longest edges keeps the shape of a needle.
std::vector<int> pieces_per_curve(const SurfaceModel& model, int cells) {
    constexpr double kLongSquare = 4;
    const int curves = static_cast<int>(model.curves().size());
    // At least two, so that patches between the same corners have no edge in common; three for sides that close on
    // themselves.
    const int least = std::min(cells, 3);
    std::vector<int> parent(curves), pieces(curves, least);
    for (int c = 0; c < curves; ++c) {
        parent[c] = c;
        if (model.curves()[c].ends[0] == model.curves()[c].ends[1]) pieces[c] = 3;
    }
    const auto root = [&](int c) {
        while (parent[c] != c) c = parent[c] = parent[parent[c]];
        return c;
    };
    const auto curve = [&](int p, int side) { return model.loops(p)[0][side].curve; };
    for (int p = 0; p < model.num_patches(); ++p) {
        for (const auto& [side, opposite] : {std::pair(0, 2), std::pair(3, 1)}) {
            const int a = root(curve(p, side)), b = root(curve(p, opposite));
            parent[a] = b;
            pieces[b] = std::max(pieces[a], pieces[b]);
        }
    }
    for (int p = 0; p < model.num_patches(); ++p) {
        const double ratio = extent_of(model.patch(p), 0, 2 * cells) / extent_of(model.patch(p), 1, 2 * cells);
        const double slender = std::max(1.0, std::max(ratio, 1 / ratio) / kLongSquare);
        const int few = std::max(least, static_cast<int>(std::lround(cells / slender)));
        const int many = std::clamp(static_cast<int>(std::lround(few * slender)), cells, kMostPieces);
        int& along = pieces[root(curve(p, 0))];
        along = std::max(along, ratio >= 1 ? many : few);
        int& across = pieces[root(curve(p, 3))];
        across = std::max(across, ratio >= 1 ? few : many);
    }
    for (int c = 0; c < curves; ++c) pieces[c] = pieces[root(c)];
    return pieces;
}

// A mesh of the patches under refinement. Half-edges on model curves carry the curve as tag.
class Builder {
  public:
    Builder(const SurfaceModel& model, const SizingRule& rule) : model_(model), rule_(rule) {}

    void start_from_grid(int cells);
    void start_from(const Background& background, std::span<const double> sizes);
    // Bisects until no triangle is marked, in passes over what is new. @returns false if max_triangles was reached
    template <class Mark>
    bool refine(const Mark& mark, int max_triangles);

    bool misrepresented(int t, const BackgroundOptions& options, double* error) const;
    bool coarse_for_gradation(int t, double longest, std::span<const double> graded) const;
    bool near_prescribed(int t) const;
    double unit_triangles() const;
    SizedBackground result() const;
    const std::vector<std::array<int, 2>>& parents() const { return parents_; }
    int num_vertices() const { return static_cast<int>(points_.size()); }
    const Connectivity& mesh() const { return mesh_; }
    const std::vector<Eigen::Vector3d>& points() const { return points_; }

  private:
    double exact_size(const SurfacePoint& at) const {
        return size_from_radius(rule_, minimal_radius(model_.patch(at.patch), at.uv));
    }
    double size_on_edge(int h, const SurfacePoint& middle) const;
    double length(int h) const { return (points_[mesh_.origin(h)] - points_[mesh_.target(h)]).norm(); }
    int longest_edge(int t) const;
    std::array<Eigen::Vector2d, 2> parameters_of(int h) const;
    SurfacePoint middle_of(int h) const;
    SurfacePoint other_side_of(int h, const SurfacePoint& middle) const;
    void bisect(int h);
    bool is_border(int h) const;
    void find_borders();

    const SurfaceModel& model_;
    const SizingRule& rule_;
    Connectivity mesh_;
    std::vector<Eigen::Vector3d> points_;
    std::vector<double> sizes_;
    std::vector<std::array<int, 2>> parents_;  // of vertices that came by bisection, in order
    std::vector<int> patch_;
    std::vector<std::array<Eigen::Vector2d, 3>> uv_;
    // Of half-edges on curves: which use, and the parameters of the curve at both ends, in the direction of the
    // half-edge. The mesh has the curves as tags.
    struct OnCurve {
        int use = -1;
        double t0 = 0, t1 = 0;
    };
    std::vector<std::array<OnCurve, 3>> border_;
    std::vector<std::array<signed char, 3>> pole_;  // of corners: the parameter that means nothing there, or -1
};

void Builder::start_from_grid(int cells) {
    std::vector<Triangle> triangles;
    const std::vector<int> pieces = pieces_per_curve(model_, cells);
    // Vertices: model vertices, then the inside of each curve, then that of each patch.
    std::vector<int> first_on_curve;
    for (const ModelVertex& v : model_.vertices()) points_.push_back(v.point);
    for (int c = 0; c < static_cast<int>(model_.curves().size()); ++c) {
        first_on_curve.push_back(static_cast<int>(points_.size()));
        for (int i = 1; i < pieces[c]; ++i)
            points_.push_back(model_.position(model_.on_curve(c, 0, static_cast<double>(i) / pieces[c])));
    }
    const auto curve_vertex = [&](int c, int i) { return first_on_curve[c] + i - 1; };
    for (int p = 0; p < model_.num_patches(); ++p) {
        const Domain domain = model_.patch(p).domain();
        const int n = pieces[model_.loops(p)[0][0].curve], m = pieces[model_.loops(p)[0][3].curve];
        const auto uniform = [&](int i, int j) {
            // The ends are the domain's own numbers, so that a side is recognised exactly.
            const Eigen::Vector2d s{static_cast<double>(i) / n, static_cast<double>(j) / m};
            return Eigen::Vector2d(
                i == n ? domain.max.x() : domain.min.x() + s.x() * (domain.max.x() - domain.min.x()),
                j == m ? domain.max.y() : domain.min.y() + s.y() * (domain.max.y() - domain.min.y()));
        };
        std::vector<int> id((n + 1) * (m + 1));
        std::vector<Eigen::Vector2d> uv((n + 1) * (m + 1));
        const int corner[4] = {0, n, m * (n + 1) + n, m * (n + 1)};
        for (int j = 0; j <= m; ++j)
            for (int i = 0; i <= n; ++i) uv[j * (n + 1) + i] = uniform(i, j);
        for (int k = 0; k < 4; ++k) id[corner[k]] = model_.start_of(model_.loops(p)[0][k]);
        for (int j = 1; j < m; ++j)
            for (int i = 1; i < n; ++i) {
                id[j * (n + 1) + i] = static_cast<int>(points_.size());
                points_.push_back(model_.patch(p).position(uniform(i, j)));
            }
        for (int s = 0; s < 4; ++s) {
            const auto [c, use] = model_.loops(p)[0][s];
            const ModelCurve& curve = model_.curves()[c];
            const int count = pieces[c];
            for (int i = 1; i < count; ++i) {
                const int at = s == 0 ? i : s == 2 ? m * (n + 1) + i : s == 3 ? i * (n + 1) : i * (n + 1) + n;
                if (curve.kind == CurveKind::Pole) {
                    id[at] = curve.ends[0];
                    continue;
                }
                const int k = curve.uses[use].reversed != (s >= 2) ? count - i : i;
                id[at] = curve_vertex(c, k);
                uv[at] = model_.on_curve(c, use, static_cast<double>(k) / count).uv;
            }
        }
        const auto add = [&](int a, int b, int c) {
            if (id[a] == id[b] || id[b] == id[c] || id[c] == id[a]) return;
            if (model_.flipped(p)) std::swap(b, c);
            triangles.push_back({id[a], id[b], id[c]});
            patch_.push_back(p);
            uv_.push_back({uv[a], uv[b], uv[c]});
        };
        for (int j = 0; j < m; ++j)
            for (int i = 0; i < n; ++i) {
                const int a = j * (n + 1) + i, b = a + 1, c = a + n + 2, d = a + n + 1;
                // The shorter diagonal; at a corner of the patch the one that ends there, as the other one joins two
                // curves, and a second patch between the same curves would have it too.
                const bool left = i == 0, right = i == n - 1, bottom = j == 0, top = j == m - 1;
                const bool through_ac = (left && bottom) || (right && top),
                           through_bd = (right && bottom) || (left && top);
                const bool shorter =
                    (points_[id[a]] - points_[id[c]]).squaredNorm() <= (points_[id[b]] - points_[id[d]]).squaredNorm();
                if (through_ac || (shorter && !through_bd)) {
                    add(a, b, c);
                    add(a, c, d);
                } else {
                    add(a, b, d);
                    add(b, c, d);
                }
            }
    }
    // Points of pole curves are not used: drop them.
    std::vector<int> renumber(points_.size(), -1);
    int used = 0;
    for (Triangle& t : triangles)
        for (int& v : t) renumber[v] = 0;
    for (std::size_t v = 0; v < points_.size(); ++v)
        if (renumber[v] == 0) {
            renumber[v] = used;
            points_[used++] = points_[v];
        }
    points_.resize(used);
    for (Triangle& t : triangles)
        for (int& v : t) v = renumber[v];
    mesh_ = Connectivity(used, triangles);
    find_borders();
    sizes_.assign(used, std::numeric_limits<double>::infinity());
    for (int t = 0; t < mesh_.num_triangles(); ++t)
        for (int k = 0; k < 3; ++k) {
            double& h = sizes_[mesh_.origin(3 * t + k)];
            h = std::min(h, size_at(model_, rule_, {patch_[t], uv_[t][k]}));
        }
}

void Builder::start_from(const Background& background, std::span<const double> sizes) {
    const auto points = points_of(background.mesh);
    points_.assign(points.begin(), points.end());
    sizes_.assign(sizes.begin(), sizes.end());
    patch_ = background.patch;
    uv_ = background.uv;
    mesh_ = Connectivity(static_cast<int>(points_.size()), triangles_of(background.mesh));
    find_borders();
}

// Parameters of the ends of h in its triangle. A pole is a whole line of parameters: it is approached along the other
// end's own line.
std::array<Eigen::Vector2d, 2> Builder::parameters_of(int h) const {
    const int t = h / 3, k = h % 3, m = (k + 1) % 3;
    Eigen::Vector2d a = uv_[t][k], b = uv_[t][m];
    if (const int axis = pole_[t][k]; axis >= 0)
        a[axis] = b[axis];
    else if (const int other = pole_[t][m]; other >= 0)
        b[other] = a[other];
    return {a, b};
}

// Whether the patch ends at h: beyond it is nothing, another patch, or the other side of a seam.
bool Builder::is_border(int h) const {
    const int g = mesh_.twin(h);
    return g < 0 || patch_[g / 3] != patch_[h / 3] || uv_[h / 3][h % 3] != uv_[g / 3][(g + 1) % 3] ||
           uv_[h / 3][(h + 1) % 3] != uv_[g / 3][g % 3];
}

void Builder::find_borders() {
    border_.assign(mesh_.num_triangles(), {});
    pole_.assign(mesh_.num_triangles(), {-1, -1, -1});
    std::vector<char> has_pole(model_.num_patches(), 0);
    for (const ModelCurve& curve : model_.curves())
        if (curve.kind == CurveKind::Pole) has_pole[curve.uses[0].patch] = 1;
    for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
        const int t = h / 3, k = h % 3, patch = patch_[t];
        if (has_pole[patch])
            for (const auto& [ref, at] : model_.border_at({patch, uv_[t][k]}))
                if (model_.curves()[ref.curve].kind == CurveKind::Pole) {
                    const Eigen::Vector2d along = model_.use(ref).image->duv(at);
                    pole_[t][k] = std::abs(along.x()) >= std::abs(along.y()) ? 0 : 1;
                }
    }
    for (int h = 0; h < 3 * mesh_.num_triangles(); ++h) {
        if (!is_border(h)) continue;
        const auto [a, b] = parameters_of(h);
        const auto from = model_.border_at({patch_[h / 3], a}), to = model_.border_at({patch_[h / 3], b});
        for (const auto& [ref, t0] : from)
            for (const auto& [other, t1] : to) {
                if (!(ref == other) || model_.curves()[ref.curve].kind == CurveKind::Pole) continue;
                mesh_.set_tag(h, ref.curve);
                border_[h / 3][h % 3] = {ref.use, t0, t1};
            }
        // A closed curve starts where it ends: the way between the two is the short one.
        auto& [use, t0, t1] = border_[h / 3][h % 3];
        if (const int curve = mesh_.tag(h);
            curve >= 0 && model_.curves()[curve].ends[0] == model_.curves()[curve].ends[1])
            for (double* t : {&t0, &t1})
                if (std::abs(t1 - t0) > 0.5 && (*t == 0 || *t == 1)) *t = 1 - *t;
    }
    for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
        if (mesh_.tag(h) >= 0 && border_[h / 3][h % 3].use < 0)
            throw std::invalid_argument(
                fmt::format("background: edge {}-{} lies on a curve of patch {} on one side only", mesh_.origin(h) + 1,
                            mesh_.target(h) + 1, patch_[h / 3] + 1));
}

int Builder::longest_edge(int t) const {
    int longest = 3 * t;
    const auto key = [&](int h) {
        // Ties by vertex numbers: both triangles of an edge see the same order.
        return std::tuple(length(h), std::max(mesh_.origin(h), mesh_.target(h)),
                          std::min(mesh_.origin(h), mesh_.target(h)));
    };
    for (const int h : {3 * t + 1, 3 * t + 2})
        if (key(h) > key(longest)) longest = h;
    return longest;
}

// Middle of the edge in the parameters of its own triangle.
SurfacePoint Builder::middle_of(int h) const {
    if (const int curve = mesh_.tag(h); curve >= 0) {
        const OnCurve& on = border_[h / 3][h % 3];
        return model_.on_curve(curve, on.use, (on.t0 + on.t1) / 2);
    }
    const auto [a, b] = parameters_of(h);
    return {patch_[h / 3], (a + b) / 2};
}

// The same point in the parameters of the neighbouring triangle.
SurfacePoint Builder::other_side_of(int h, const SurfacePoint& middle) const {
    return mesh_.tag(h) < 0 ? middle : middle_of(mesh_.twin(h));
}

double Builder::size_on_edge(int h, const SurfacePoint& middle) const {
    double size = exact_size(middle);
    const int curve = mesh_.tag(h);
    if (curve < 0) return size;
    if (mesh_.twin(h) >= 0) size = std::min(size, exact_size(other_side_of(h, middle)));
    if (is_feature(model_.curves()[curve].kind)) {
        const OnCurve& on = border_[h / 3][h % 3];
        size = std::min(size, size_from_radius(rule_, curve_radius(model_, curve, (on.t0 + on.t1) / 2)));
    }
    return size;
}

void Builder::bisect(int h) {
    const int g = mesh_.twin(h), curve = mesh_.tag(h);
    const SurfacePoint middle = middle_of(h);
    const SurfacePoint beyond = g >= 0 ? other_side_of(h, middle) : middle;
    parents_.push_back({mesh_.origin(h), mesh_.target(h)});
    sizes_.push_back(size_on_edge(h, middle));
    const OnCurve on = border_[h / 3][h % 3];
    points_.push_back(curve >= 0 ? model_.curve_point(curve, (on.t0 + on.t1) / 2) : model_.position(middle));
    mesh_.split(h);
    const auto cut = [&](int side, const Eigen::Vector2d& uv) {
        // a b c became a m c, and m b c was added.
        const int t = side / 3, k = side % 3, next = (k + 1) % 3, last = (k + 2) % 3;
        std::array<OnCurve, 3> added;
        std::array<signed char, 3> pole{-1, pole_[t][next], pole_[t][last]};
        added[1] = border_[t][next];
        if (OnCurve& cut_curve = border_[t][k]; curve >= 0) {
            const double tm = (cut_curve.t0 + cut_curve.t1) / 2;
            added[0] = {cut_curve.use, tm, cut_curve.t1};
            cut_curve.t1 = tm;
        }
        border_[t][next] = {};
        border_.push_back(added);
        pole_.push_back(pole);
        pole_[t][next] = -1;
        uv_.push_back({uv, uv_[t][next], uv_[t][last]});
        patch_.push_back(patch_[t]);
        uv_[t][next] = uv;
    };
    cut(h, middle.uv);
    if (g >= 0) cut(g, beyond.uv);
}

template <class Mark>
bool Builder::refine(const Mark& mark, int max_triangles) {
    std::vector<int> queue(mesh_.num_triangles());
    for (int t = 0; t < mesh_.num_triangles(); ++t) queue[t] = t;
    std::vector<int> next;
    while (!queue.empty()) {
        next.clear();
        for (const int start : queue) {
            if (!mark(start)) continue;
            if (mesh_.num_triangles() + 2 > max_triangles) return false;
            // Follow longest edges until one is longest for both its triangles [Rivara 1997], and cut that one.
            int t = start;
            for (;;) {
                const int h = longest_edge(t), g = mesh_.twin(h);
                if (g < 0 || mesh_.twin(longest_edge(g / 3)) == h) {
                    const int first_new = mesh_.num_triangles();
                    bisect(h);
                    next.push_back(h / 3);
                    if (g >= 0) next.push_back(g / 3);
                    for (int fresh = first_new; fresh < mesh_.num_triangles(); ++fresh) next.push_back(fresh);
                    break;
                }
                t = g / 3;
            }
            next.push_back(start);
        }
        std::sort(next.begin(), next.end());
        next.erase(std::unique(next.begin(), next.end()), next.end());
        queue.swap(next);
    }
    return true;
}

bool Builder::misrepresented(int t, const BackgroundOptions& options, double* error) const {
    const int longest = longest_edge(t);
    const Triangle v = mesh_.triangle(t);
    const double smallest = std::min({sizes_[v[0]], sizes_[v[1]], sizes_[v[2]]});
    const double reach = length(longest);
    const Eigen::Vector3d cross = (points_[v[1]] - points_[v[0]]).cross(points_[v[2]] - points_[v[0]]);
    if (metric_length(reach, smallest, smallest) <= options.finest) {
        // The mesh cannot show the map in more detail, but a size below all corners may hide inside.
        const SurfacePoint centre{patch_[t], (uv_[t][0] + uv_[t][1] + uv_[t][2]) / 3};
        return reach > options.finest * exact_size(centre);
    }
    if (cross.norm() < kLeastAspect * reach * reach) return true;
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const int a = mesh_.origin(h), b = mesh_.target(h);
        const SurfacePoint middle = middle_of(h);
        const Eigen::Vector3d chord = points_[b] - points_[a];
        const double L = chord.norm();
        const Eigen::Vector3d gap = model_.position(middle) - (points_[a] + points_[b]) / 2;
        if (gap.cross(chord).norm() > options.chord_tolerance * L * L) return true;
        const double exact = size_on_edge(h, middle);
        if (L <= options.finest * std::min(exact, smallest)) continue;
        const double deviation = std::abs(std::log(2 * exact / (sizes_[a] + sizes_[b])));
        if (deviation > options.size_tolerance) return true;
        *error = std::max(*error, deviation);
    }
    const double centre = exact_size({patch_[t], (uv_[t][0] + uv_[t][1] + uv_[t][2]) / 3});
    const double deviation = std::abs(std::log(3 * centre / (sizes_[v[0]] + sizes_[v[1]] + sizes_[v[2]])));
    if (deviation > options.size_tolerance) return true;
    *error = std::max(*error, deviation);
    return false;
}

bool Builder::coarse_for_gradation(int t, double longest, std::span<const double> graded) const {
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const double a = graded[mesh_.origin(h)], b = graded[mesh_.target(h)];
        if (std::max(a, b) > 1.1 * std::min(a, b) && length(h) > longest * std::min(a, b)) return true;
    }
    return false;
}

// Number of triangles of a unit mesh, from the sizes at the vertices so far.
double Builder::unit_triangles() const {
    double sum = 0;
    for (int t = 0; t < mesh_.num_triangles(); ++t) {
        const Triangle v = mesh_.triangle(t);
        const double area = (points_[v[1]] - points_[v[0]]).cross(points_[v[2]] - points_[v[0]]).norm() / 2;
        double density = 0;
        for (const int x : v) density += 1 / (sizes_[x] * sizes_[x]) / 3;
        sum += area * density;
    }
    return sum / (std::numbers::sqrt3 / 4);
}

bool Builder::near_prescribed(int t) const {
    for (const SizingRule::At& at : rule_.at) {
        const Triangle v = mesh_.triangle(t);
        const double reach = length(longest_edge(t));
        if (reach <= at.size) continue;
        // Within one edge length of the triangle's middle: the triangle that holds the point is among them.
        if ((at.point - (points_[v[0]] + points_[v[1]] + points_[v[2]]) / 3).norm() <= reach) return true;
    }
    return false;
}

SizedBackground Builder::result() const {
    std::vector<Triangle> triangles(mesh_.num_triangles());
    for (int t = 0; t < mesh_.num_triangles(); ++t) triangles[t] = mesh_.triangle(t);
    return {{make_mesh(points_, triangles), patch_, uv_}, sizes_};
}

}  // namespace

SizedBackground make_background(const SurfaceModel& model, const SizingRule& rule, const BackgroundOptions& options) {
    check(rule);
    if (options.cells < 2)
        throw std::invalid_argument("make_background: cells = " + std::to_string(options.cells) + " must be 2 or more");
    if (!(options.size_tolerance > 0) || !(options.chord_tolerance > 0) || !(options.finest > 0))
        throw std::invalid_argument("make_background: tolerances must be positive");
    Builder builder(model, rule);
    const double share = std::min(1.0, static_cast<double>(SurfaceModel::kMany) / std::max(model.num_patches(), 1));
    builder.start_from_grid(std::max(2, static_cast<int>(std::lround(options.cells * std::sqrt(share)))));
    // Refining for sizes that will be refused in the end takes long: the first grid tells the order of magnitude.
    if (const double expected = builder.unit_triangles(); expected > 2 * options.max_unit_triangles)
        throw std::length_error(fmt::format("the sizes ask for about {:.15g} triangles, more than {:.0f}",
                                            std::round(expected), options.max_unit_triangles));
    double error = 0;
    const bool resolved =
        builder.refine([&](int t) { return builder.near_prescribed(t) || builder.misrepresented(t, options, &error); },
                       options.max_triangles);
    SizedBackground result = builder.result();
    lower_to_prescribed(rule.at, points_of(result.background.mesh), result.sizes);
    result.largest_error = error;
    result.resolved = resolved;
    return result;
}

std::vector<double> geometric_sizes(const SurfaceModel& model, const Background& background, const SizingRule& rule) {
    check(rule);
    std::vector<double> sizes(background.mesh.n_vertices(), std::numeric_limits<double>::infinity());
    const std::vector<Triangle> triangles = triangles_of(background.mesh);
    for (std::size_t t = 0; t < triangles.size(); ++t)
        for (int k = 0; k < 3; ++k) {
            double& h = sizes[triangles[t][k]];
            h = std::min(h, size_at(model, rule, {background.patch[t], background.uv[t][k]}));
        }
    lower_to_prescribed(rule.at, points_of(background.mesh), sizes);
    return sizes;
}

int refine_for_gradation(const SurfaceModel& model, const SizingRule& rule, double longest, SizedBackground& sized,
                         std::vector<double>& graded, int max_triangles) {
    Builder builder(model, rule);
    builder.start_from(sized.background, sized.sizes);
    std::size_t known = graded.size();
    builder.refine(
        [&](int t) {
            // Sizes of vertices that are new: between those of their parents, until they are graded again.
            for (; known < static_cast<std::size_t>(builder.num_vertices()); ++known) {
                const auto [a, b] =
                    builder.parents()[graded.size() - (builder.num_vertices() - builder.parents().size())];
                graded.push_back(std::sqrt(graded[a] * graded[b]));
            }
            return builder.coarse_for_gradation(t, longest, graded);
        },
        max_triangles);
    const int cuts = static_cast<int>(builder.parents().size());
    sized = builder.result();
    return cuts;
}

}  // namespace gradus
