#include "gradus/surface/subdivision.hpp"

#include <opensubdiv/bfr/refinerSurfaceFactory.h>
#include <opensubdiv/bfr/surface.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefiner.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <algorithm>
#include <cmath>
#include <map>
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

Part square(const Vector2d& low, double width) { return {low, {width, 0}, {0, width}, {0, 0}}; }

// The quadrilateral of a corner, the middles of both edges there, and the middle of the face.
Part corner_of_triangle(const Vector2d& before, const Vector2d& corner, const Vector2d& after) {
    const Vector2d a = (corner + after) / 2, b = (corner + before) / 2, middle = (before + corner + after) / 3;
    return {corner, a - corner, b - corner, corner - a - b + middle};
}

// The parts of a face: the whole of a quadrilateral, or one at each corner.
std::vector<Part> parts_of(const osd::Bfr::Parameterization& parameters, bool whole) {
    if (whole) return {square({0, 0}, 1)};
    std::vector<Part> parts;
    if (parameters.GetType() == osd::Bfr::Parameterization::TRI) {
        const Vector2d corners[] = {{0, 0}, {1, 0}, {0, 1}};
        for (int k = 0; k < 3; ++k)
            parts.push_back(corner_of_triangle(corners[(k + 2) % 3], corners[k], corners[(k + 1) % 3]));
    } else if (parameters.HasSubFaces()) {
        for (int part = 0; part < parameters.GetFaceSize(); ++part) {
            const double zero[2] = {0, 0};
            double low[2];
            parameters.ConvertNormalizedSubFaceToCoord(part, zero, low);
            parts.push_back(square({low[0], low[1]}, 0.5));
        }
    } else {
        for (const Vector2d& low : {Vector2d(0, 0), Vector2d(0.5, 0), Vector2d(0.5, 0.5), Vector2d(0, 0.5)})
            parts.push_back(square(low, 0.5));
    }
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
               std::shared_ptr<const std::vector<double>> points, const Part& part)
        : shared_(std::move(shared)),
          surface_(std::move(surface)),
          points_(std::move(points)),
          part_(part),
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
    // Around a vertex faces are joined by edges: as many edges as faces, or one more at a boundary.
    std::vector<int> edges(cage.points.size(), 0), faces(cage.points.size(), 0), open(cage.points.size(), 0);
    for (const auto& [edge, of] : uses)
        for (const int v : edge) ++edges[v], open[v] += of.size() == 1;
    for (const auto& face : cage.faces)
        for (const int v : face) ++faces[v];
    for (int v = 0; v < std::ssize(edges); ++v) {
        if (open[v] > 2) return "vertex " + name(v) + ": surfaces touch there without an edge";
        if (faces[v] == 2 && edges[v] == 2)
            return "vertex " + name(v) + " is inside the surface and has two faces only";
    }
    return "";
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
    for (int f = 0; f < std::ssize(cage.faces); ++f) {
        auto surface = std::make_shared<LimitPatch::Surface>();
        if (!shared->factory->InitVertexSurface(f, surface.get()))
            continue;  // a hole, or at a boundary without a surface
        auto patch_points =
            std::make_shared<std::vector<double>>(3 * static_cast<std::size_t>(surface->GetNumPatchPoints()));
        surface->PreparePatchPoints(points.data(), 3, patch_points->data(), 3);
        for (const Part& part : parts_of(surface->GetParameterization(), all_quads)) {
            result.patches.push_back(std::make_unique<LimitPatch>(shared, surface, patch_points, part));
            result.face.push_back(f);
        }
    }
    return result;
}

}  // namespace gradus
