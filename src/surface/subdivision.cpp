#include "gradus/surface/subdivision.hpp"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefiner.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "gradus/mesh/edge.hpp"

namespace gradus {
namespace {

namespace osd = OpenSubdiv;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Edge = std::array<int, 2>;

// Levels of patches around extraordinary vertices before the cap.
constexpr int kLevels = 10;

std::string name(int index) { return std::to_string(index + 1); }
std::string name(const Edge& e) { return name(e[0]) + "-" + name(e[1]); }

// A bilinear map of the unit square to the parameters of a face.
struct Part {
    Vector2d origin, along_s, along_t, twist;

    Vector2d at(const Vector2d& st) const {
        return origin + st.x() * along_s + st.y() * along_t + st.x() * st.y() * twist;
    }
};

// The quadrilateral of a corner, the middles of both edges there, and the middle of the face.
Part part_at(const Vector2d& before, const Vector2d& corner, const Vector2d& after, const Vector2d& middle) {
    const Vector2d a = (corner + after) / 2, b = (corner + before) / 2;
    return {corner, a - corner, b - corner, corner - a - b + middle};
}

// The parts of a face: the whole of a quadrilateral, or one at each corner.
std::vector<Part> parts_of(const osd::Bfr::Parameterization& parameters, bool whole) {
    if (whole) return {{{0, 0}, {1, 0}, {0, 1}, {0, 0}}};
    std::vector<Part> parts;
    const int n = parameters.GetFaceSize();
    if (parameters.HasSubFaces()) {
        for (int part = 0; part < n; ++part) {
            const double zero[2] = {0, 0};
            double low[2];
            parameters.ConvertNormalizedSubFaceToCoord(part, zero, low);
            parts.push_back({{low[0], low[1]}, {0.5, 0}, {0, 0.5}, {0, 0}});
        }
        return parts;
    }
    const bool is_triangle = parameters.GetType() == osd::Bfr::Parameterization::TRI;
    const std::vector<Vector2d> corners = is_triangle ? std::vector<Vector2d>{{0, 0}, {1, 0}, {0, 1}}
                                                      : std::vector<Vector2d>{{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    Vector2d middle(0, 0);
    for (const Vector2d& corner : corners) middle += corner / n;
    for (int k = 0; k < n; ++k)
        parts.push_back(part_at(corners[(k + n - 1) % n], corners[k], corners[(k + 1) % n], middle));
    return parts;
}

// Part of a surface of OpenSubdiv.
class LimitPatch final : public ParametricSurface {
  public:
    using Surface = osd::Bfr::Surface<double>;
    struct Shared {
        std::shared_ptr<const osd::Far::TopologyRefiner> refiner;
        std::unique_ptr<const osd::Bfr::RefinerSurfaceFactory<>> factory;
    };

    LimitPatch(std::shared_ptr<const Shared> shared, std::shared_ptr<const Surface> surface,
               std::shared_ptr<const std::vector<double>> points, const Part& part, std::vector<Vector2d> unbounded)
        : shared_(std::move(shared)),
          surface_(std::move(surface)),
          points_(std::move(points)),
          part_(part),
          unbounded_(std::move(unbounded)),
          may_be_turned_(surface_->GetParameterization().GetType() == osd::Bfr::Parameterization::TRI &&
                         !surface_->IsRegular()) {}

    Domain domain() const override { return {}; }
    Vector3d position(const Vector2d& st) const override {
        Vector3d p;
        surface_->Evaluate(part_.at(st).data(), points_->data(), 3, p.data());
        return p;
    }
    Jet1 jet1(const Vector2d& st) const override {
        const Jet1 jet = face_jet1(part_.at(st));
        const Vector2d ds = part_.along_s + st.y() * part_.twist, dt = part_.along_t + st.x() * part_.twist;
        return {jet.p, first(jet, ds), first(jet, dt)};
    }
    Jet2 jet2(const Vector2d& st) const override {
        const Jet2 jet = face_jet2(part_.at(st));
        const Vector2d ds = part_.along_s + st.y() * part_.twist, dt = part_.along_t + st.x() * part_.twist;
        return {jet.p,
                first(jet, ds),
                first(jet, dt),
                second(jet, ds, ds),
                second(jet, ds, dt) + first(jet, part_.twist),
                second(jet, dt, dt)};
    }

    // Away from corners where curvature grows without bound: at an extraordinary vertex of valence 5 by a tenth with
    // each halving of the distance, beyond all sizes in the end, but over less of the surface than an element covers.
    Vector2d curvature_place(const Vector2d& st) const override {
        constexpr double kReach = 0.125;  // of the face: elements are rarely smaller
        const double reach = kReach / (part_.along_s.norm() + part_.along_t.norm()) * 2;
        for (const Vector2d& corner : unbounded_) {
            const Vector2d away = st - corner;
            const double distance = away.norm();
            if (distance >= reach) continue;
            // At the corner itself towards the middle.
            const Vector2d middle = (Vector2d(0.5, 0.5) - corner).normalized();
            return corner + reach * (distance > 1e-9 ? Vector2d(away / distance) : middle);
        }
        return st;
    }

  private:
    // Derivatives along directions of the face's parameters.
    template <class Jet>
    static Vector3d first(const Jet& jet, const Vector2d& a) {
        return a.x() * jet.du + a.y() * jet.dv;
    }
    static Vector3d second(const Jet2& jet, const Vector2d& a, const Vector2d& b) {
        return a.x() * b.x() * jet.duu + (a.x() * b.y() + a.y() * b.x()) * jet.duv + a.y() * b.y() * jet.dvv;
    }

    Jet1 face_jet1(const Vector2d& uv) const {
        Jet1 jet;
        surface_->Evaluate(uv.data(), points_->data(), 3, jet.p.data(), jet.du.data(), jet.dv.data());
        return jet;
    }
    Jet2 face_jet2(const Vector2d& uv) const {
        Jet2 jet;
        surface_->Evaluate(uv.data(), points_->data(), 3, jet.p.data(), jet.du.data(), jet.dv.data(), jet.duu.data(),
                           jet.duv.data(), jet.dvv.data());
        if (may_be_turned_ && is_turned(uv, jet))
            for (Vector3d* d : {&jet.duu, &jet.duv, &jet.dvv}) *d = -*d;
        return jet;
    }
    // OpenSubdiv 3.5 forgets that parameters of the triangles in the middle run backwards: second derivatives have the
    // wrong sign there. First derivatives, which are right, tell it by how they change on the way to the middle of the
    // face.
    bool is_turned(const Vector2d& uv, const Jet2& jet) const {
        constexpr double kStep = 1e-4;
        const Vector2d way = (Vector2d(1. / 3, 1. / 3) - uv) * kStep + Vector2d(1e-7, 2e-7);
        const Jet1 there = face_jet1(uv + way);
        const Vector3d u = way.x() * jet.duu + way.y() * jet.duv, v = way.x() * jet.duv + way.y() * jet.dvv;
        return u.dot(there.du - jet.du) + v.dot(there.dv - jet.dv) < 0;
    }

    std::shared_ptr<const Shared> shared_;
    std::shared_ptr<const Surface> surface_;
    std::shared_ptr<const std::vector<double>> points_;  // of the patches of the surface
    Part part_;
    std::vector<Vector2d> unbounded_;  // corners of the domain
    bool may_be_turned_;
};

// Why not, for the faces by themselves.
std::string why_no_faces(const Cage& cage) {
    const int n = static_cast<int>(cage.points.size());
    for (int v = 0; v < n; ++v)
        if (!cage.points[v].allFinite()) return "vertex " + name(v) + " is not finite";
    if (cage.faces.empty()) return "the cage has no faces";
    for (int f = 0; f < std::ssize(cage.faces); ++f) {
        std::vector<int> corners = cage.faces[f];
        if (corners.size() < 3) return "face " + name(f) + " has " + std::to_string(corners.size()) + " corners";
        for (const int v : corners)
            if (v < 0 || v >= n) return "face " + name(f) + " has vertex " + name(v) + " of " + std::to_string(n);
        std::sort(corners.begin(), corners.end());
        if (const auto twice = std::adjacent_find(corners.begin(), corners.end()); twice != corners.end())
            return "face " + name(f) + " has vertex " + name(*twice) + " twice";
    }
    return "";
}

// Why not, for how they meet.
// @param uses  of each edge, the faces with it, from 1 on; negative where they run from its larger vertex to the
// smaller
// Corners of faces that edges join at a vertex, as trees: one for each vertex where the faces are one fan.
class Fans {
  public:
    explicit Fans(const Cage& cage) : cage_(cage) {
        for (const auto& face : cage.faces) first_.push_back(first_.back() + static_cast<int>(face.size()));
        up_.resize(first_.back());
        std::iota(up_.begin(), up_.end(), 0);
    }
    void join(int face, int other, int vertex) { up_[root(corner(face, vertex))] = root(corner(other, vertex)); }
    int fan_of(int face, int vertex) { return root(corner(face, vertex)); }

  private:
    int corner(int face, int vertex) const {
        const std::vector<int>& of = cage_.faces[face];
        return first_[face] + static_cast<int>(std::find(of.begin(), of.end(), vertex) - of.begin());
    }
    int root(int c) {
        while (up_[c] != c) c = up_[c] = up_[up_[c]];
        return c;
    }

    const Cage& cage_;
    std::vector<int> first_{0}, up_;
};

std::string why_not_around_vertices(const Cage& cage, const std::map<Edge, std::vector<int>>& uses) {
    Fans fans(cage);
    std::vector<int> edges(cage.points.size(), 0), faces(cage.points.size(), 0), fan(cage.points.size(), -1);
    for (const auto& [edge, of] : uses)
        for (const int v : edge) {
            ++edges[v];
            if (of.size() == 2) fans.join(std::abs(of[0]) - 1, std::abs(of[1]) - 1, v);
        }
    for (int f = 0; f < std::ssize(cage.faces); ++f)
        for (const int v : cage.faces[f]) {
            ++faces[v];
            const int of = fans.fan_of(f, v);
            if (fan[v] >= 0 && fan[v] != of) return "vertex " + name(v) + ": surfaces touch there without an edge";
            fan[v] = of;
        }
    for (int v = 0; v < std::ssize(edges); ++v)
        if (faces[v] == 2 && edges[v] == 2)
            return "vertex " + name(v) + " is inside the surface and has two faces only";
    return "";
}

std::string why_no_surface(const Cage& cage, const std::map<Edge, std::vector<int>>& uses) {
    for (const auto& [edge, faces] : uses) {
        if (faces.size() > 2)
            return "edge " + name(edge) + " has " + std::to_string(faces.size()) +
                   " faces: " + std::to_string(std::abs(faces[0])) + ", " + std::to_string(std::abs(faces[1])) + ", " +
                   std::to_string(std::abs(faces[2])) + (faces.size() > 3 ? " ..." : "");
        if (faces.size() == 2 && (faces[0] > 0) == (faces[1] > 0))
            return "faces " + std::to_string(std::abs(faces[0])) + " and " + std::to_string(std::abs(faces[1])) +
                   " run along edge " + name(edge) +
                   " in the same direction: one of them is to be turned, or the surface has one side only";
    }
    return why_not_around_vertices(cage, uses);
}

std::string why_no_tags(const Cage& cage, const std::map<Edge, std::vector<int>>& uses) {
    for (const Cage::Crease& crease : cage.creases) {
        if (!uses.contains(edge_between(crease.edge[0], crease.edge[1])))
            return "crease " + name(crease.edge) + " is no edge";
        if (!(crease.sharpness >= 0))
            return "crease " + name(crease.edge) + " has a sharpness of " + std::to_string(crease.sharpness);
    }
    for (const Cage::Corner& corner : cage.corners) {
        if (corner.vertex < 0 || corner.vertex >= std::ssize(cage.points))
            return "corner " + name(corner.vertex) + " is no vertex";
        if (!(corner.sharpness >= 0))
            return "corner " + name(corner.vertex) + " has a sharpness of " + std::to_string(corner.sharpness);
    }
    for (const int face : cage.holes)
        if (face < 0 || face >= std::ssize(cage.faces)) return "hole " + name(face) + " is no face";
    if (!cage.labels.empty() && cage.labels.size() != cage.faces.size())
        return std::to_string(cage.labels.size()) + " labels for " + std::to_string(cage.faces.size()) + " faces";
    return "";
}

std::shared_ptr<const osd::Far::TopologyRefiner> refiner_of(const Cage& cage, SubdivisionScheme scheme) {
    std::vector<int> corners, vertices, crease_ends, corner_vertices;
    for (const auto& face : cage.faces) {
        corners.push_back(static_cast<int>(face.size()));
        vertices.insert(vertices.end(), face.begin(), face.end());
    }
    std::vector<float> crease_weights, corner_weights;
    for (const Cage::Crease& crease : cage.creases) {
        crease_ends.insert(crease_ends.end(), crease.edge.begin(), crease.edge.end());
        crease_weights.push_back(static_cast<float>(std::min(crease.sharpness, Cage::kSharp)));
    }
    for (const Cage::Corner& corner : cage.corners) {
        corner_vertices.push_back(corner.vertex);
        corner_weights.push_back(static_cast<float>(std::min(corner.sharpness, Cage::kSharp)));
    }
    osd::Far::TopologyDescriptor topology;
    topology.numVertices = static_cast<int>(cage.points.size());
    topology.numFaces = static_cast<int>(cage.faces.size());
    topology.numVertsPerFace = corners.data();
    topology.vertIndicesPerFace = vertices.data();
    topology.numCreases = static_cast<int>(crease_weights.size());
    topology.creaseVertexIndexPairs = crease_ends.data();
    topology.creaseWeights = crease_weights.data();
    topology.numCorners = static_cast<int>(corner_weights.size());
    topology.cornerVertexIndices = corner_vertices.data();
    topology.cornerWeights = corner_weights.data();
    topology.numHoles = static_cast<int>(cage.holes.size());
    topology.holeIndices = cage.holes.data();

    using Sdc = osd::Sdc::Options;
    Sdc options;
    options.SetVtxBoundaryInterpolation(cage.boundary == Cage::Boundary::None    ? Sdc::VTX_BOUNDARY_NONE
                                        : cage.boundary == Cage::Boundary::Edges ? Sdc::VTX_BOUNDARY_EDGE_ONLY
                                                                                 : Sdc::VTX_BOUNDARY_EDGE_AND_CORNER);
    if (cage.chaikin) options.SetCreasingMethod(Sdc::CREASE_CHAIKIN);
    if (cage.smooth_triangles) options.SetTriangleSubdivision(Sdc::TRI_SUB_SMOOTH);
    using Factory = osd::Far::TopologyRefinerFactory<osd::Far::TopologyDescriptor>;
    return std::shared_ptr<const osd::Far::TopologyRefiner>(Factory::Create(
        topology, Factory::Options(scheme == SubdivisionScheme::Loop ? osd::Sdc::SCHEME_LOOP : osd::Sdc::SCHEME_CATMARK,
                                   options)));
}

}  // namespace

namespace {

// Curves of the limit surface, found by what they are of the cage: an edge, the half of an edge at a vertex, or the
// line from the middle of an edge to the middle of a face.
class CurvesOfCage {
  public:
    CurvesOfCage(const Cage& cage, Topology& topology) : topology_(topology) {
        for (const Cage::Crease& crease : cage.creases)
            if (crease.sharpness >= Cage::kSharp) kept_.push_back(edge_between(crease.edge[0], crease.edge[1]));
        add_label_borders(cage);
        for (const Cage::Corner& corner : cage.corners)
            if (corner.sharpness >= Cage::kSharp) corners_.push_back(corner.vertex);
        std::sort(kept_.begin(), kept_.end());
        std::sort(corners_.begin(), corners_.end());
    }

    // The last patch is all of a face: its loop goes along the edges.
    void bound_whole(const std::vector<int>& face) {
        for (int k = 0; k < 4; ++k) {
            const int a = face[k], b = face[(k + 1) % 4];
            const Edge edge = edge_between(a, b);
            use({edge, kWhole}, k, a != edge[0], is_kept(edge));
        }
    }
    // The last patch is the part at a corner of a face.
    void bound_part(int number, const std::vector<int>& face, int corner) {
        const int n = static_cast<int>(face.size()), v = face[corner];
        const Edge next = edge_between(v, face[(corner + 1) % n]), last = edge_between(v, face[(corner + n - 1) % n]);
        use({next, v == next[0] ? 0 : 1}, 0, false, is_kept(next));
        use({next, kFirstFace + number}, 1, false, false);
        use({last, kFirstFace + number}, 2, true, false);
        use({last, v == last[0] ? 0 : 1}, 3, true, is_kept(last));
    }
    // Patches of OpenSubdiv 3.5 leave gaps where sharpness is averaged along creases: @throws naming the edge
    void check_gaps(const std::vector<int>& face_of) const {
        constexpr double kGap = 1e-6;  // of the length of the edge
        for (const auto& [key, curve] : curves_) {
            const std::vector<CurveUse>& uses = topology_.curves[curve].uses;
            const auto point = [&](const CurveUse& use, double t) {
                return topology_.patches[use.patch].surface->position(use.image->uv(t));
            };
            for (const double t : {0.0, 0.5, 1.0}) {
                if (uses.size() < 2) continue;
                const double length = (point(uses[0], 1) - point(uses[0], 0)).norm();
                if ((point(uses[0], t) - point(uses[1], t)).norm() > kGap * length)
                    throw std::invalid_argument("edge " + name(key.first) + ": the limit surfaces of faces " +
                                                name(face_of[uses[0].patch]) + " and " + name(face_of[uses[1].patch]) +
                                                " do not meet there, with creases by Chaikin's rule");
            }
        }
    }
    // Ends of curves at vertices without a tangent plane.
    void find_tips() {
        for (const auto& [key, curve] : curves_) {
            const auto& [edge, what] = key;
            for (const int end : {0, 1}) {
                const bool at_vertex = what == kWhole || (what == end && what < kWhole);
                if (at_vertex && std::binary_search(corners_.begin(), corners_.end(), edge[end]))
                    topology_.tips.push_back({curve, what == kWhole && end == 1});
            }
        }
    }

  private:
    static constexpr int kWhole = 2, kFirstFace = 3;  // after both halves
    using Key = std::pair<Edge, int>;

    void add_label_borders(const Cage& cage) {
        if (cage.labels.empty()) return;
        std::map<Edge, int> label;
        for (std::size_t f = 0; f < cage.faces.size(); ++f) {
            const std::vector<int>& face = cage.faces[f];
            for (std::size_t k = 0; k < face.size(); ++k) {
                const auto [known, is_new] =
                    label.emplace(edge_between(face[k], face[(k + 1) % face.size()]), cage.labels[f]);
                if (!is_new && known->second != cage.labels[f]) kept_.push_back(known->first);
            }
        }
    }

    // Creases, and borders of labels.
    bool is_kept(const Edge& edge) const { return std::binary_search(kept_.begin(), kept_.end(), edge); }

    // Side k of the last patch is a use of a curve.
    void use(const Key& key, int k, bool reversed, bool kept) {
        const int patch = static_cast<int>(topology_.patches.size()) - 1;
        const auto [known, is_new] = curves_.emplace(key, static_cast<int>(topology_.curves.size()));
        if (is_new) topology_.curves.emplace_back();
        Topology::Curve& curve = topology_.curves[known->second];
        const Vector2d corners[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        const Vector2d &from = corners[k], &to = corners[(k + 1) % 4];
        topology_.patches[patch].loops[0].push_back({known->second, static_cast<int>(curve.uses.size())});
        curve.uses.push_back({patch, reversed, reversed ? straight_image(to, from) : straight_image(from, to)});
        if (curve.uses.size() == 2) curve.kind = kept ? CurveKind::Crease : CurveKind::Smooth;
    }

    Topology& topology_;
    std::vector<Edge> kept_;
    std::vector<int> corners_;
    std::map<Key, int> curves_;
};

// Vertices at which the curvature of the limit surface has no bound: those inside that have another number of edges
// than regular ones (at few of them it has), and infinitely sharp corners.
std::vector<char> unbounded_vertices(const Cage& cage, SubdivisionScheme scheme,
                                     const osd::Far::TopologyLevel& topology) {
    const int regular = scheme == SubdivisionScheme::Loop ? 6 : 4;
    std::vector<char> result(cage.points.size());
    for (int v = 0; v < std::ssize(result); ++v)
        result[v] = !topology.IsVertexBoundary(v) && topology.GetVertexFaces(v).size() != regular;
    for (const Cage::Corner& corner : cage.corners)
        if (corner.sharpness >= Cage::kSharp) result[corner.vertex] = 1;
    return result;
}

}  // namespace

std::string_view name_of(SubdivisionScheme scheme) {
    return scheme == SubdivisionScheme::Loop ? "loop" : "catmull-clark";
}

std::string why_no_limit_surface(const Cage& cage, SubdivisionScheme scheme) {
    if (std::string why = why_no_faces(cage); !why.empty()) return why;
    for (int f = 0; f < std::ssize(cage.faces); ++f)
        if (scheme == SubdivisionScheme::Loop && cage.faces[f].size() != 3)
            return "face " + name(f) + " has " + std::to_string(cage.faces[f].size()) +
                   " corners, and Loop's scheme is for triangles";
    std::map<Edge, std::vector<int>> uses;
    for (int f = 0; f < std::ssize(cage.faces); ++f)
        for (std::size_t k = 0, n = cage.faces[f].size(); k < n; ++k) {
            const int a = cage.faces[f][k], b = cage.faces[f][(k + 1) % n];
            uses[edge_between(a, b)].push_back(a < b ? f + 1 : -(f + 1));
        }
    if (std::string why = why_no_surface(cage, uses); !why.empty()) return why;
    return why_no_tags(cage, uses);
}

void sharpen(Cage& cage, double angle) {
    std::map<Edge, Vector3d> normal;
    for (const std::vector<int>& face : cage.faces) {
        // The area vector of a face, whatever its shape.
        Vector3d area = Vector3d::Zero();
        for (std::size_t k = 1; k + 1 < face.size(); ++k)
            area +=
                (cage.points[face[k]] - cage.points[face[0]]).cross(cage.points[face[k + 1]] - cage.points[face[0]]);
        const Vector3d n = area.stableNormalized();
        for (std::size_t k = 0; k < face.size(); ++k) {
            const auto [known, is_new] = normal.emplace(edge_between(face[k], face[(k + 1) % face.size()]), n);
            if (!is_new && std::atan2(known->second.cross(n).norm(), known->second.dot(n)) >= angle)
                cage.creases.push_back({known->first, Cage::kSharp});
        }
    }
}

LimitSurface limit_surface(const Cage& cage, SubdivisionScheme scheme) {
    if (const std::string why = why_no_limit_surface(cage, scheme); !why.empty()) throw std::invalid_argument(why);
    auto shared = std::make_shared<LimitPatch::Shared>();
    shared->refiner = refiner_of(cage, scheme);
    if (!shared->refiner) throw std::invalid_argument("the cage has no limit surface");
    using Factory = osd::Bfr::RefinerSurfaceFactory<>;
    Factory::Options options;
    options.SetApproxLevelSmooth(kLevels).SetApproxLevelSharp(kLevels);
    shared->factory = std::make_unique<const Factory>(*shared->refiner, options);

    std::vector<double> points;
    for (const Vector3d& p : cage.points) points.insert(points.end(), p.begin(), p.end());
    LimitSurface result;
    // Neighbours are to have whole sides in common.
    const bool all_quads =
        std::all_of(cage.faces.begin(), cage.faces.end(), [](const auto& face) { return face.size() == 4; });
    CurvesOfCage curves(cage, result.topology);
    const std::vector<char> unbounded = unbounded_vertices(cage, scheme, shared->refiner->GetLevel(0));
    const auto unbounded_corners = [&](const std::vector<int>& face, int part) {
        std::vector<Vector2d> corners;
        if (all_quads) {
            const Vector2d domain[] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
            for (int k = 0; k < 4; ++k)
                if (unbounded[face[k]]) corners.push_back(domain[k]);
            return corners;
        }
        if (unbounded[face[part]]) corners.emplace_back(0, 0);
        if (scheme == SubdivisionScheme::CatmullClark && face.size() != 4) corners.emplace_back(1, 1);
        return corners;
    };
    for (int f = 0; f < std::ssize(cage.faces); ++f) {
        auto surface = std::make_shared<LimitPatch::Surface>();
        if (!shared->factory->InitVertexSurface(f, surface.get()))
            continue;  // a hole, or at a boundary without a surface
        auto patch_points =
            std::make_shared<std::vector<double>>(3 * static_cast<std::size_t>(surface->GetNumPatchPoints()));
        surface->PreparePatchPoints(points.data(), 3, patch_points->data(), 3);
        const std::vector<Part> parts = parts_of(surface->GetParameterization(), all_quads);
        for (int k = 0; k < std::ssize(parts); ++k) {
            result.topology.patches.push_back({std::make_unique<LimitPatch>(shared, surface, patch_points, parts[k],
                                                                            unbounded_corners(cage.faces[f], k)),
                                               {{}},
                                               "face " + name(f)});
            result.face.push_back(f);
            all_quads ? curves.bound_whole(cage.faces[f]) : curves.bound_part(f, cage.faces[f], k);
        }
    }
    if (cage.chaikin) curves.check_gaps(result.face);
    curves.find_tips();
    return result;
}

}  // namespace gradus
