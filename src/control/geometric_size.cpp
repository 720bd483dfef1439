#include "gradus/control/geometric_size.hpp"

#include "gradus/control/metric.hpp"
#include "gradus/curvature/principal.hpp"
#include "gradus/mesh/connectivity.hpp"
#include "gradus/surface/locate.hpp"
#include "patch_meshes.hpp"

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

// Parameters that cut a curve into pieces of about the same length.
std::vector<double> even_pieces(const SurfaceModel& model, int curve, int pieces) {
    if (pieces == 1) return {0, 1};
    const int samples = 8 * pieces;
    std::vector<double> sample{0}, length{0};
    Eigen::Vector3d last = model.curve_point(curve, 0);
    for (int k = 1; k <= samples; ++k) {
        sample.push_back(k);
        const Eigen::Vector3d p = model.curve_point(curve, static_cast<double>(k) / samples);
        length.push_back(length.back() + (p - last).norm());
        last = p;
    }
    std::vector<double> t = equal_pieces(sample, length, pieces);
    for (double& at : t) at /= samples;
    return t;
}

// Pieces that turn by more than this are halved: their chords would be far from them, and triangles beside them turn
// over where they are cut later.
constexpr double kMostTurn = std::numbers::pi / 8;

void halve_where_it_turns(const SurfaceModel& model, int curve, std::vector<double>& t) {
    const auto& uses = model.curves()[curve].uses;
    if (std::all_of(uses.begin(), uses.end(), [](const CurveUse& use) { return use.image->is_straight(); })) return;
    constexpr int kDeepest = 10;
    const auto direction = [&](double at) -> Eigen::Vector3d {
        return model.curve_jet(curve, at).d.stableNormalized();
    };
    const double cosine = std::cos(kMostTurn);
    std::vector<double> cut{0};
    const auto add = [&](auto&& self, double from, double to, int depth) -> void {
        const double middle = (from + to) / 2;
        const Eigen::Vector3d a = direction(from), m = direction(middle), b = direction(to);
        if (depth > 0 && (a.dot(b) < cosine || a.dot(m) < cosine || m.dot(b) < cosine)) {
            self(self, from, middle, depth - 1);
            self(self, middle, to, depth - 1);
            return;
        }
        cut.push_back(to);
    };
    for (std::size_t k = 0; k + 1 < t.size(); ++k) add(add, t[k], t[k + 1], kDeepest);
    t = std::move(cut);
}

// The curves cut for a first mesh whose edges have a length on each patch; poles too, so that their triangles have
// parameters of their own.
CutCurves cut_curves(const SurfaceModel& model, std::span<const double> length_on_patch) {
    constexpr int kPolePieces = 8;
    std::vector<int> pieces;
    for (const ModelCurve& curve : model.curves()) {
        double longest = 0;
        for (const CurveUse& use : curve.uses) longest = std::max(longest, curve.length / length_on_patch[use.patch]);
        pieces.push_back(static_cast<int>(std::lround(std::min<double>(longest, kMostPieces))));
    }
    cut_into_polygons(model, pieces);
    std::vector<std::vector<double>> t;
    for (int c = 0; c < static_cast<int>(pieces.size()); ++c) {
        if (model.curves()[c].kind != CurveKind::Pole) {
            t.push_back(even_pieces(model, c, pieces[c]));
            halve_where_it_turns(model, c, t.back());
            continue;
        }
        std::vector<double>& even = t.emplace_back();
        for (int k = 0; k <= kPolePieces; ++k) even.push_back(static_cast<double>(k) / kPolePieces);
    }
    return {model, std::move(t)};
}

// A mesh of the patches under refinement. Half-edges on model curves carry the curve as tag.
class Builder {
  public:
    // @param rule  none: sizes are not kept
    Builder(const SurfaceModel& model, const SizingRule* rule) : model_(model), rule_(rule) {}

    // With about `cells` edges across each patch.
    void start(double cells);
    void start_from(const Background& background, std::span<const double> sizes);
    // Bisects until no triangle is marked, in passes over what is new. @returns false if max_triangles was reached
    template <class Mark>
    bool refine(const Mark& mark, int max_triangles);

    bool misrepresented(int t, const BackgroundOptions& options, double* error) const;
    bool coarse_for_gradation(int t, double longest, std::span<const double> graded) const;
    bool near_prescribed(int t) const;
    double gap(int t) const;
    double unit_triangles() const;
    SizedBackground result() const;
    const std::vector<std::array<int, 2>>& parents() const { return parents_; }
    int num_vertices() const { return static_cast<int>(points_.size()); }
    const Connectivity& mesh() const { return mesh_; }
    const std::vector<Eigen::Vector3d>& points() const { return points_; }

  private:
    double exact_size(const SurfacePoint& at) const {
        return size_from_radius(*rule_, minimal_radius(model_.patch(at.patch), at.uv));
    }
    double size_on_edge(int h, const SurfacePoint& middle) const;
    // Of the way over the surface, by two chords. Where parameters run into a cusp the chord between the ends may be
    // shorter than those of its halves, and bisection by it has no end.
    double length(int h) const { return way_[h / 3][h % 3]; }
    void measure(int h);
    int longest_edge(int t) const;
    std::array<Eigen::Vector2d, 2> parameters_of(int h) const;
    SurfacePoint middle_of(int h) const;
    SurfacePoint centre_of(int t) const;
    SurfacePoint other_side_of(int h, const SurfacePoint& middle) const;
    void bisect(int h);
    bool is_border(int h) const;
    void find_borders();

    const SurfaceModel& model_;
    const SizingRule* rule_;
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
    std::vector<std::array<double, 3>> way_;        // of half-edges: see length()
    std::vector<std::array<signed char, 3>> pole_;  // of corners: the parameter that means nothing there, or -1
};

void Builder::start(double cells) {
    std::vector<double> length;
    for (int p = 0; p < model_.num_patches(); ++p) length.push_back(std::sqrt(model_.area(p)) / cells);
    const PatchMeshes meshes(model_, cut_curves(model_, length),
                             [&](const SurfacePoint& at, const Eigen::Vector3d&, int&) { return length[at.patch]; });
    constexpr int kUnused = -1;
    std::vector<int> vertex(meshes.num_vertices(), kUnused);
    std::vector<Triangle> triangles;
    meshes.for_each_triangle([&](int p, const std::array<int, 3>& corners) {
        const PatchMesh& mesh = meshes.patches()[p];
        Triangle& t = triangles.emplace_back();
        for (int k = 0; k < 3; ++k) {
            int& v = vertex[mesh.number[corners[k]]];
            if (v == kUnused) {
                v = static_cast<int>(points_.size());
                points_.push_back(model_.position({p, mesh.uv[corners[k]]}));
            }
            t[k] = v;
        }
        patch_.push_back(p);
        uv_.push_back({mesh.uv[corners[0]], mesh.uv[corners[1]], mesh.uv[corners[2]]});
    });
    mesh_ = Connectivity(static_cast<int>(points_.size()), triangles);
    find_borders();
    sizes_.assign(points_.size(), std::numeric_limits<double>::infinity());
    for (int p = 0; p < model_.num_patches(); ++p) {
        const PatchMesh& mesh = meshes.patches()[p];
        for (std::size_t i = 0; i < mesh.uv.size(); ++i)
            if (const int v = vertex[mesh.number[i]]; v != kUnused)
                sizes_[v] = std::min(sizes_[v], size_at(model_, *rule_, {p, mesh.uv[i]}));
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
            if (int axis = 0; on_pole(model_, {patch, uv_[t][k]}, axis)) pole_[t][k] = static_cast<signed char>(axis);
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
    way_.assign(mesh_.num_triangles(), {0, 0, 0});
    for (int h = 0; h < 3 * mesh_.num_triangles(); ++h)
        if (mesh_.twin(h) < h) measure(h);
}

void Builder::measure(int h) {
    const Eigen::Vector3d middle = model_.position(middle_of(h));
    way_[h / 3][h % 3] = (points_[mesh_.origin(h)] - middle).norm() + (middle - points_[mesh_.target(h)]).norm();
    if (const int g = mesh_.twin(h); g >= 0) way_[g / 3][g % 3] = way_[h / 3][h % 3];
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

// What means nothing at a pole is that of the other corners.
SurfacePoint Builder::centre_of(int t) const {
    Eigen::Vector2d sum(0, 0), count(0, 0);
    for (int k = 0; k < 3; ++k)
        for (int axis = 0; axis < 2; ++axis)
            if (pole_[t][k] != axis) sum[axis] += uv_[t][k][axis], count[axis] += 1;
    return {patch_[t], sum.cwiseQuotient(count.cwiseMax(1))};
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
        size = std::min(size, size_from_radius(*rule_, curve_radius(model_, curve, (on.t0 + on.t1) / 2)));
    }
    return size;
}

void Builder::bisect(int h) {
    const int g = mesh_.twin(h), curve = mesh_.tag(h);
    const SurfacePoint middle = middle_of(h);
    const SurfacePoint beyond = g >= 0 ? other_side_of(h, middle) : middle;
    parents_.push_back({mesh_.origin(h), mesh_.target(h)});
    if (rule_) sizes_.push_back(size_on_edge(h, middle));
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
        way_.push_back({0, way_[t][next], 0});
        pole_.push_back(pole);
        pole_[t][next] = -1;
        uv_.push_back({uv, uv_[t][next], uv_[t][last]});
        patch_.push_back(patch_[t]);
        uv_[t][next] = uv;
    };
    const int first_new = static_cast<int>(border_.size());
    cut(h, middle.uv);
    if (g >= 0) cut(g, beyond.uv);
    // Both halves, and the edges from the middle to the corners opposite.
    measure(h);
    measure(3 * first_new);
    measure(3 * first_new + 2);
    if (g >= 0) measure(3 * (first_new + 1) + 2);
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
        return reach > options.finest * exact_size(centre_of(t));
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
    const double centre = exact_size(centre_of(t));
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

// Between a triangle and the surface, at the middles of its edges and its own.
double Builder::gap(int t) const {
    double largest = 0;
    for (int h = 3 * t; h < 3 * t + 3; ++h) {
        const Eigen::Vector3d &a = points_[mesh_.origin(h)], &b = points_[mesh_.target(h)];
        const Eigen::Vector3d off = model_.position(middle_of(h)) - (a + b) / 2;
        const double chord = (b - a).norm();
        largest = std::max(largest, chord > 0 ? off.cross(b - a).norm() / chord : off.norm());
    }
    const Triangle v = mesh_.triangle(t);
    const Eigen::Vector3d normal =
        (points_[v[1]] - points_[v[0]]).cross(points_[v[2]] - points_[v[0]]).stableNormalized();
    const Eigen::Vector3d off = model_.position(centre_of(t)) - (points_[v[0]] + points_[v[1]] + points_[v[2]]) / 3;
    return std::max(largest, std::abs(off.dot(normal)));
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
    for (const SizingRule::At& at : rule_->at) {
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
    constexpr double kLeastPrescribed = 1e-9;  // of the diagonal
    for (const SizingRule::At& at : rule.at)
        if (at.size < kLeastPrescribed * model.diagonal())
            throw std::invalid_argument(
                fmt::format("the size {:g} at {:g} {:g} {:g} is below {:g} of the diagonal: rounding leaves no "
                            "triangles that small",
                            at.size, at.point.x(), at.point.y(), at.point.z(), kLeastPrescribed));
    if (options.cells < 2)
        throw std::invalid_argument("make_background: cells = " + std::to_string(options.cells) + " must be 2 or more");
    if (!(options.size_tolerance > 0) || !(options.chord_tolerance > 0) || !(options.finest > 0))
        throw std::invalid_argument("make_background: tolerances must be positive");
    Builder builder(model, &rule);
    const double share = std::min(1.0, static_cast<double>(SurfaceModel::kMany) / std::max(model.num_patches(), 1));
    builder.start(options.cells * std::sqrt(share));
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

FacetedSurface facets_within(const SurfaceModel& model, const Background& background, double tolerance,
                             int max_triangles) {
    if (!(tolerance > 0)) throw std::invalid_argument("facets_within: tolerance must be positive");
    Builder builder(model, nullptr);
    builder.start_from(background, {});
    double largest = 0;
    const auto is_far = [&](int t) {
        const double gap = builder.gap(t);
        if (gap <= tolerance) largest = std::max(largest, gap);
        return gap > tolerance;
    };
    if (!builder.refine(is_far, max_triangles))
        throw std::length_error(
            fmt::format("facets within {:g} of the surface are more than {}", tolerance, max_triangles));
    return {std::move(builder.result().background), largest};
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
    Builder builder(model, &rule);
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
