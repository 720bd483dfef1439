#include "gradus/remesh/parametric.hpp"

#include "editor.hpp"
#include "gradus/plane/delaunay.hpp"
#include "gradus/remesh/curves.hpp"
#include "optimise.hpp"

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>

namespace gradus {

namespace {

constexpr double kTarget =
    1.01;  // lengths asked of the generator, whose edges come out somewhat short where the metric varies
constexpr int kRepairRounds = 20;

// Numbers of the vertices that patches share: model vertices first, then the inner points of each curve.
struct SharedVertices {
    std::vector<std::vector<double>> t;  // parameters along each curve
    std::vector<int> first;              // number of the first inner point of each curve
    int count = 0;

    SharedVertices(const SurfaceModel& model, const ControlSpace& control) : t(discretise_curves(model, control)) {
        count = static_cast<int>(model.vertices().size());
        for (const auto& parameters : t) {
            first.push_back(count);
            count += std::max(0, static_cast<int>(parameters.size()) - 2);
        }
    }
    int on_curve(const SurfaceModel& model, int curve, int i) const {
        const int last = static_cast<int>(t[curve].size()) - 1;
        return i == 0      ? model.curves()[curve].ends[0]
               : i == last ? model.curves()[curve].ends[1]
                           : first[curve] + i - 1;
    }
};

// The mesh of one patch: shared vertices by their number, inner ones from `inner` on, still to be numbered.
struct PatchMesh {
    std::vector<Eigen::Vector2d> uv;
    std::vector<int> cell;    // triangle of the control space under each point
    std::vector<int> number;  // of shared vertices; -1: inner
    std::vector<std::array<int, 3>> triangles;
    std::vector<std::array<int, 2>> poles;  // sides that are a point in space
};

PatchMesh mesh_patch(const SurfaceModel& model, const ControlSpace& control, const SharedVertices& shared, int p) {
    PatchMesh result;
    PlanarDomain domain;
    const auto add = [&](const SurfacePoint& at, int number) {
        domain.points.push_back(at.uv);
        domain.hints.push_back(control.locate(at));
        result.number.push_back(number);
    };
    std::vector<std::size_t> poles;  // segments
    // Once around each loop: every use without its last point. A pole is one segment.
    for (const std::vector<UseRef>& loop : model.loops(p)) {
        const int first = static_cast<int>(domain.points.size());
        for (const UseRef& ref : loop) {
            const auto [c, u] = ref;
            const bool reversed = model.use(ref).reversed;
            add(model.on_curve(c, u, reversed ? 1 : 0), model.start_of(ref));
            if (model.curves()[c].kind == CurveKind::Pole) {
                poles.push_back(domain.points.size() - 1);
                continue;
            }
            const int last = static_cast<int>(shared.t[c].size()) - 1;
            for (int k = 1; k < last; ++k) {
                const int i = reversed ? last - k : k;
                add(model.on_curve(c, u, shared.t[c][i]), shared.on_curve(model, c, i));
            }
        }
        const int end = static_cast<int>(domain.points.size());
        for (int i = first; i < end; ++i) domain.segments.push_back({i, i + 1 < end ? i + 1 : first});
    }
    for (const std::size_t pole : poles) result.poles.push_back(domain.segments[pole]);

    const ParametricSurface& patch = model.patch(p);
    const MetricField metric = [&](const Eigen::Vector2d& uv, int& hint) {
        const Jet1 jet = patch.jet1(uv);
        if (hint < 0) hint = control.locate({p, uv});
        const double h = control.size(jet.p, hint);
        const double F = jet.du.dot(jet.dv);
        Eigen::Matrix2d M;
        M << jet.du.squaredNorm(), F, F, jet.dv.squaredNorm();
        return Eigen::Matrix2d(M / (h * h));
    };
    PlanarMesh planar = mesh_domain(domain, metric, {.target = kTarget});
    result.uv = std::move(planar.points);
    result.cell = std::move(planar.hints);
    result.triangles = std::move(planar.triangles);
    result.number.resize(result.uv.size(), -1);
    return result;
}

// Cuts edge (a, b) of a patch mesh in its middle.
void cut_edge(PatchMesh& mesh, int a, int b) {
    const int m = static_cast<int>(mesh.uv.size());
    mesh.uv.push_back((mesh.uv[a] + mesh.uv[b]) / 2);
    mesh.cell.push_back(mesh.cell[a]);
    mesh.number.push_back(-1);
    const std::size_t before = mesh.triangles.size();
    for (std::size_t t = 0; t < before; ++t)
        for (int k = 0; k < 3; ++k) {
            auto& v = mesh.triangles[t];
            const int x = v[k], y = v[(k + 1) % 3], z = v[(k + 2) % 3];
            if ((x == a && y == b) || (x == b && y == a)) {
                v = {x, m, z};
                mesh.triangles.push_back({m, y, z});
                break;
            }
        }
}

void split_in_middle(PatchMesh& mesh, int t) {
    const auto [a, b, c] = mesh.triangles[t];
    const int m = static_cast<int>(mesh.uv.size());
    mesh.uv.push_back((mesh.uv[a] + mesh.uv[b] + mesh.uv[c]) / 3);
    mesh.cell.push_back(mesh.cell[a]);
    mesh.number.push_back(-1);
    mesh.triangles[t] = {a, b, m};
    mesh.triangles.push_back({b, c, m});
    mesh.triangles.push_back({c, a, m});
}

struct EdgeUse {
    std::array<int, 2> ends;  // global numbers, in the direction of the triangle
    int patch;
    std::array<int, 2> local;
};

// Edges inside patches that two patches would share, or that join a vertex to itself (on a seam), are cut: the same two
// vertices may have only one edge. Triangles on the side of a pole have lost that side and vanish.
class Assembly {
  public:
    Assembly(const SurfaceModel& model, const SharedVertices& shared, std::vector<PatchMesh> patches)
        : model_(model), patches_(std::move(patches)), shared_(shared.count), count_(shared.count) {
        for (PatchMesh& mesh : patches_) number_inner(mesh);
        split_twin_triangles();
        for (int round = 0; round < kRepairRounds && cut_conflicts(); ++round) {
        }
    }

    std::vector<Triangle> triangles() const {
        std::vector<Triangle> all;
        for (int p = 0; p < static_cast<int>(patches_.size()); ++p)
            for (const auto& t : patches_[p].triangles) {
                Triangle v{patches_[p].number[t[0]], patches_[p].number[t[1]], patches_[p].number[t[2]]};
                if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;
                if (model_.flipped(p)) std::swap(v[1], v[2]);
                all.push_back(v);
            }
        return all;
    }
    int num_vertices() const { return count_; }
    const std::vector<PatchMesh>& patches() const { return patches_; }

  private:
    void number_inner(PatchMesh& mesh) {
        for (int& number : mesh.number)
            if (number < 0) number = count_++;
    }

    bool is_pole(int p, int a, int b) const {
        return std::any_of(patches_[p].poles.begin(), patches_[p].poles.end(), [&](const std::array<int, 2>& pole) {
            return (pole[0] == a && pole[1] == b) || (pole[0] == b && pole[1] == a);
        });
    }

    bool cut_conflicts() {
        std::vector<EdgeUse> uses, conflicts;
        for (int p = 0; p < static_cast<int>(patches_.size()); ++p) {
            const PatchMesh& mesh = patches_[p];
            const bool flipped = model_.flipped(p);
            for (const auto& t : mesh.triangles) {
                bool vanishes = false;
                for (int k = 0; k < 3; ++k) {
                    const int a = t[k], b = t[(k + 1) % 3];
                    if (mesh.number[a] != mesh.number[b]) continue;
                    vanishes = true;
                    if (!is_pole(p, a, b)) conflicts.push_back({{mesh.number[a], mesh.number[b]}, p, {a, b}});
                }
                if (vanishes) continue;
                for (int k = 0; k < 3; ++k) {
                    int a = t[k], b = t[(k + 1) % 3];
                    // Only vertices on curves are in several places.
                    if (mesh.number[a] >= shared_ && mesh.number[b] >= shared_) continue;
                    if (flipped) std::swap(a, b);
                    uses.push_back({{mesh.number[a], mesh.number[b]}, p, {a, b}});
                }
            }
        }
        std::sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
            return std::tie(x.ends, x.patch, x.local) < std::tie(y.ends, y.patch, y.local);
        });
        const auto inside = [&](const EdgeUse& e) {
            // On the border of its patch an edge has one triangle there: it has no twin with the same local ends.
            const std::array<int, 2> back{e.ends[1], e.ends[0]}, local{e.local[1], e.local[0]};
            const auto first =
                std::lower_bound(uses.begin(), uses.end(), back,
                                 [](const EdgeUse& x, const std::array<int, 2>& ends) { return x.ends < ends; });
            for (auto i = first; i != uses.end() && i->ends == back; ++i)
                if (i->patch == e.patch && i->local == local) return true;
            return false;
        };
        for (std::size_t i = 0; i < uses.size();) {
            std::size_t j = i;
            while (j < uses.size() && uses[j].ends == uses[i].ends) ++j;
            if (j - i > 1)
                for (std::size_t k = i; k < j; ++k)
                    if (inside(uses[k])) conflicts.push_back(uses[k]);
            i = j;
        }
        if (conflicts.empty()) return false;
        std::vector<std::pair<int, std::array<int, 2>>> cut;
        for (const EdgeUse& e : conflicts)
            cut.push_back({e.patch, {std::min(e.local[0], e.local[1]), std::max(e.local[0], e.local[1])}});
        std::sort(cut.begin(), cut.end());
        cut.erase(std::unique(cut.begin(), cut.end()), cut.end());
        for (const auto& [p, ends] : cut) {
            cut_edge(patches_[p], ends[0], ends[1]);
            number_inner(patches_[p]);
        }
        return true;
    }

    // Two triangles on the same three vertices enclose nothing: each gets a point in its middle. Only corners that
    // patches share can be those of two triangles, and these are numbered first.
    void split_twin_triangles() {
        std::map<std::array<int, 3>, std::vector<std::pair<int, int>>> by_corners;  // patch and triangle
        for (int p = 0; p < static_cast<int>(patches_.size()); ++p)
            for (int t = 0; t < static_cast<int>(patches_[p].triangles.size()); ++t) {
                const auto& v = patches_[p].triangles[t];
                const auto& number = patches_[p].number;
                std::array<int, 3> corners{number[v[0]], number[v[1]], number[v[2]]};
                std::sort(corners.begin(), corners.end());
                if (corners[0] < corners[1] && corners[1] < corners[2] && corners[2] < shared_)
                    by_corners[corners].emplace_back(p, t);
            }
        for (const auto& [corners, uses] : by_corners)
            if (uses.size() > 1)
                for (const auto& [p, t] : uses) {
                    split_in_middle(patches_[p], t);
                    number_inner(patches_[p]);
                }
    }

    const SurfaceModel& model_;
    std::vector<PatchMesh> patches_;
    int shared_;  // vertices that patches share: the first ones
    int count_;
};

Vertex vertex_from(const Foot& foot) {
    Vertex v;
    v.place = foot.place;
    v.p = foot.point;
    v.n = foot.normal;
    v.h = foot.size;
    v.g = std::cbrt(foot.size * foot.size);
    return v;
}

// True where the surface has several normals at a pole, as at the tip of a cone.
bool is_tip(const SurfaceModel& model, int pole) {
    constexpr double kCosine = 0.966;  // of 15 degrees, from which curves are creases
    const Eigen::Vector3d first = model.normal(model.on_curve(pole, 0, 0));
    for (const double t : {0.25, 0.5, 0.75, 1.0})
        if (model.normal(model.on_curve(pole, 0, t)).dot(first) < kCosine) return true;
    return false;
}

std::vector<Vertex> place_vertices(const SurfaceModel& model, const PatchSupport& support, const ControlSpace& control,
                                   const SharedVertices& shared, const Assembly& assembly) {
    std::vector<Vertex> vertices(assembly.num_vertices());
    const int corners = static_cast<int>(model.vertices().size());
    std::vector<char> on_feature(corners, 0), on_crease(corners, 0);
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const CurveKind kind = model.curves()[c].kind;
        const bool several_normals = kind == CurveKind::Crease || (kind == CurveKind::Pole && is_tip(model, c));
        for (const int end : model.curves()[c].ends) {
            if (is_feature(kind) || kind == CurveKind::Pole) on_feature[end] = 1;
            if (several_normals) on_crease[end] = 1;
        }
    }
    for (int v = 0; v < corners; ++v) {
        const SurfacePoint at = model.vertices()[v].places.front();
        const bool fixed = on_feature[v] || model.vertices()[v].tip;
        vertices[v] = vertex_from(support.foot({at, -1, 0, control.locate(at), fixed ? v : -1}));
        vertices[v].bound = fixed ? Bound::Fixed : Bound::Free;
        if (const auto junction = support.junction(v)) {
            vertices[v] = vertex_from(support.foot(*junction));
            vertices[v].bound = Bound::Curve;
        }
        if ((on_crease[v] || model.vertices()[v].tip) && vertices[v].bound == Bound::Fixed)
            vertices[v].lean = kAnyNormal;
    }
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        const bool feature = is_feature(model.curves()[c].kind);
        for (int i = 1; i + 1 < static_cast<int>(shared.t[c].size()); ++i) {
            const SurfacePoint at = model.on_curve(c, 0, shared.t[c][i]);
            Vertex& v = vertices[shared.on_curve(model, c, i)];
            v = vertex_from(support.foot({at, feature ? c : -1, shared.t[c][i], control.locate(at)}));
            v.bound = feature ? Bound::Curve : Bound::Free;
        }
    }
    for (int p = 0; p < model.num_patches(); ++p) {
        const PatchMesh& mesh = assembly.patches()[p];
        for (std::size_t i = 0; i < mesh.uv.size(); ++i)
            if (mesh.number[i] >= shared.count)
                vertices[mesh.number[i]] = vertex_from(support.foot({{p, mesh.uv[i]}, -1, 0, mesh.cell[i]}));
    }
    return vertices;
}

void tag_features(const SurfaceModel& model, const PatchSupport& support, const SharedVertices& shared,
                  Connectivity& mesh) {
    for (int c = 0; c < static_cast<int>(model.curves().size()); ++c) {
        if (!is_feature(model.curves()[c].kind)) continue;
        for (int i = 0; i + 1 < static_cast<int>(shared.t[c].size()); ++i) {
            const int edge = mesh.find_edge(shared.on_curve(model, c, i), shared.on_curve(model, c, i + 1));
            if (edge < 0)
                throw std::logic_error("remesh: a piece of curve " + std::to_string(c) + " is not in the mesh");
            mesh.set_tag(edge, support.chain_of(c));
        }
    }
}

// Every place of a vertex on a feature: one per side or corner that has it.
std::vector<SurfacePoint> places_of(const SurfaceModel& model, const Vertex& v) {
    std::vector<SurfacePoint> places;
    if (v.bound == Bound::Curve) {
        const ModelCurve& curve = model.curves()[v.place.curve];
        if (v.place.t == 0 || v.place.t == 1) return model.vertices()[curve.ends[v.place.t == 1]].places;
        for (int use = 0; use < static_cast<int>(curve.uses.size()); ++use)
            places.push_back(model.on_curve(v.place.curve, use, v.place.t));
    }
    if (v.bound == Bound::Fixed) places = model.vertices()[v.place.vertex].places;
    return places;
}

// The patch that all corners of a triangle lie on, all of them on features; of several the one that faces as the
// triangle does.
int common_patch(const SurfaceModel& model, const Vertex& a, const Vertex& b, const Vertex& c) {
    const Eigen::Vector3d facing = (b.p - a.p).cross(c.p - a.p);
    const std::array<std::vector<SurfacePoint>, 3> places{places_of(model, a), places_of(model, b),
                                                          places_of(model, c)};
    int best = a.place.at.patch;
    double most = -std::numeric_limits<double>::infinity();
    for (const SurfacePoint& first : places[0]) {
        double agreement = 0;
        for (const auto& of_corner : places) {
            const auto there = std::find_if(of_corner.begin(), of_corner.end(),
                                            [&](const SurfacePoint& at) { return at.patch == first.patch; });
            agreement +=
                there != of_corner.end() ? model.normal(*there).dot(facing) : -std::numeric_limits<double>::infinity();
        }
        if (agreement > most) most = agreement, best = first.patch;
    }
    return best;
}

// The patch under a triangle: that of all its corners, or the one its middle falls on.
int patch_under(const SurfaceModel& model, const Support& support, const Vertex& a, const Vertex& b, const Vertex& c) {
    const auto inside = [](const Vertex& v) { return v.bound == Bound::Free; };
    if (inside(a) && inside(b) && inside(c) && a.place.at.patch == b.place.at.patch &&
        b.place.at.patch == c.place.at.patch)
        return a.place.at.patch;
    const Eigen::Vector3d middle = (a.p + b.p + c.p) / 3;
    for (const Vertex* v : {&a, &b, &c}) {
        if (!inside(*v)) continue;
        if (const auto foot = support.move(v->place, v->p, middle)) return foot->place.at.patch;
    }
    for (const Vertex* v : {&a, &b, &c})
        if (inside(*v)) return v->place.at.patch;
    return common_patch(model, a, b, c);
}

SurfaceMesh export_mesh(const SurfaceModel& model, const Support& support, const Editor& editor) {
    SurfaceMesh result;
    const Connectivity& mesh = editor.mesh();
    for (const Vertex& v : editor.vertices()) {
        result.points.push_back(model.position(v.place.at));
        result.places.push_back(v.place.at);
        result.sizes.push_back(v.h);
    }
    for (int t = 0; t < mesh.num_triangles(); ++t) {
        const Triangle v = mesh.triangle(t);
        result.triangles.push_back(v);
        result.patches.push_back(
            patch_under(model, support, editor.vertex(v[0]), editor.vertex(v[1]), editor.vertex(v[2])));
        for (int h = 3 * t; h < 3 * t + 3; ++h)
            if (mesh.tag(h) >= 0 && mesh.twin(h) < h) result.features.push_back({mesh.origin(h), mesh.target(h)});
    }
    return result;
}

}  // namespace

RemeshResult remesh(const SurfaceModel& model, const ControlSpace& control, const RemeshOptions& options) {
    RemeshResult result;
    RemeshStatistics& statistics = result.statistics;
    statistics.predicted_triangles = check_estimate(control, options);
    std::optional<tbb::global_control> limit;
    if (options.threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, options.threads);

    StageClock clock(statistics.seconds);
    const SharedVertices shared(model, control);
    clock.done("curves");
    std::vector<PatchMesh> patches(model.num_patches());
    tbb::parallel_for(0, model.num_patches(), [&](int p) { patches[p] = mesh_patch(model, control, shared, p); });
    clock.done("generation");
    const Assembly assembly(model, shared, std::move(patches));
    const PatchSupport support(model, control);
    Connectivity mesh(assembly.num_vertices(), assembly.triangles());
    tag_features(model, support, shared, mesh);
    Editor editor(support, place_vertices(model, support, control, shared, assembly), std::move(mesh));
    statistics.generated_triangles = editor.mesh().num_live_triangles();
    clock.done("assembly");

    take_report(optimise(editor, {.fast = options.fast, .goal = options.goal}, clock), statistics);
    result.mesh = export_mesh(model, support, editor);
    clock.done("export");
    return result;
}

}  // namespace gradus
