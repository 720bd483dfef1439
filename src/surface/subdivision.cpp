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

namespace gradus {
namespace {

namespace osd = OpenSubdiv;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Edge = std::array<int, 2>;

// Levels of patches around extraordinary vertices before the cap.
constexpr int kLevels = 10;

Edge sorted(int a, int b) { return {std::min(a, b), std::max(a, b)}; }
std::string name(int index) { return std::to_string(index + 1); }
std::string name(const Edge& e) { return name(e[0]) + "-" + name(e[1]); }

// One surface of OpenSubdiv, or the part of it at a corner of a face that is no quadrilateral.
class LimitPatch final : public ParametricSurface {
  public:
    using Surface = osd::Bfr::Surface<double>;
    struct Shared {
        std::shared_ptr<const osd::Far::TopologyRefiner> refiner;
        std::unique_ptr<const osd::Bfr::RefinerSurfaceFactory<>> factory;
    };

    /// @param low, scale  of the square of the surface's parameters that it is
    LimitPatch(std::shared_ptr<const Shared> shared, std::shared_ptr<const Surface> surface, std::shared_ptr<const std::vector<double>> points,
               const Vector2d& low, double scale)
        : shared_(std::move(shared)), surface_(std::move(surface)), points_(std::move(points)), low_(low), scale_(scale) {}

    Domain domain() const override { return {}; }
    Vector3d position(const Vector2d& uv) const override {
        Vector3d p;
        surface_->Evaluate(at(uv).data(), points_->data(), 3, p.data());
        return p;
    }
    Jet1 jet1(const Vector2d& uv) const override {
        Jet1 jet;
        surface_->Evaluate(at(uv).data(), points_->data(), 3, jet.p.data(), jet.du.data(), jet.dv.data());
        jet.du *= scale_;
        jet.dv *= scale_;
        return jet;
    }
    Jet2 jet2(const Vector2d& uv) const override {
        Jet2 jet;
        surface_->Evaluate(at(uv).data(), points_->data(), 3, jet.p.data(), jet.du.data(), jet.dv.data(), jet.duu.data(), jet.duv.data(), jet.dvv.data());
        jet.du *= scale_;
        jet.dv *= scale_;
        for (Vector3d* d : {&jet.duu, &jet.duv, &jet.dvv}) *d *= scale_ * scale_;
        return jet;
    }

  private:
    Vector2d at(const Vector2d& uv) const { return low_ + scale_ * uv; }

    std::shared_ptr<const Shared> shared_;
    std::shared_ptr<const Surface> surface_;
    std::shared_ptr<const std::vector<double>> points_;  // of the patches of the surface
    Vector2d low_;
    double scale_;
};

// Lower corners of the squares that a face is cut into, and how wide they are: one at each corner, or the whole face.
struct Parts {
    std::vector<Vector2d> low;
    double width;
};
Parts parts_of(const osd::Bfr::Parameterization& parameters, bool whole) {
    if (whole) return {{{0, 0}}, 1};
    if (!parameters.HasSubFaces()) return {{{0, 0}, {0.5, 0}, {0.5, 0.5}, {0, 0.5}}, 0.5};
    Parts parts{{}, 0.5};
    for (int part = 0; part < parameters.GetFaceSize(); ++part) {
        const double zero[2] = {0, 0};
        double low[2];
        parameters.ConvertNormalizedSubFaceToCoord(part, zero, low);
        parts.low.emplace_back(low[0], low[1]);
    }
    return parts;
}

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
// @param uses  of each edge, the faces with it, from 1 on; negative where they run from its larger vertex to the smaller
std::string why_no_surface(const Cage& cage, const std::map<Edge, std::vector<int>>& uses) {
    for (const auto& [edge, faces] : uses) {
        if (faces.size() > 2)
            return "edge " + name(edge) + " has " + std::to_string(faces.size()) + " faces: " + std::to_string(std::abs(faces[0])) + ", " +
                   std::to_string(std::abs(faces[1])) + ", " + std::to_string(std::abs(faces[2])) + (faces.size() > 3 ? " ..." : "");
        if (faces.size() == 2 && (faces[0] > 0) == (faces[1] > 0))
            return "faces " + std::to_string(std::abs(faces[0])) + " and " + std::to_string(std::abs(faces[1])) + " run along edge " + name(edge) +
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
        if (faces[v] == 2 && edges[v] == 2) return "vertex " + name(v) + " is inside the surface and has two faces only";
    }
    return "";
}

std::string why_no_tags(const Cage& cage, const std::map<Edge, std::vector<int>>& uses) {
    for (const Cage::Crease& crease : cage.creases) {
        if (!uses.contains(sorted(crease.edge[0], crease.edge[1]))) return "crease " + name(crease.edge) + " is no edge";
        if (!(crease.sharpness >= 0)) return "crease " + name(crease.edge) + " has a sharpness of " + std::to_string(crease.sharpness);
    }
    for (const Cage::Corner& corner : cage.corners) {
        if (corner.vertex < 0 || corner.vertex >= std::ssize(cage.points)) return "corner " + name(corner.vertex) + " is no vertex";
        if (!(corner.sharpness >= 0)) return "corner " + name(corner.vertex) + " has a sharpness of " + std::to_string(corner.sharpness);
    }
    for (const int face : cage.holes)
        if (face < 0 || face >= std::ssize(cage.faces)) return "hole " + name(face) + " is no face";
    if (!cage.labels.empty() && cage.labels.size() != cage.faces.size())
        return std::to_string(cage.labels.size()) + " labels for " + std::to_string(cage.faces.size()) + " faces";
    return "";
}

std::shared_ptr<const osd::Far::TopologyRefiner> refiner_of(const Cage& cage) {
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
    return std::shared_ptr<const osd::Far::TopologyRefiner>(Factory::Create(topology, Factory::Options(osd::Sdc::SCHEME_CATMARK, options)));
}

}  // namespace

std::string_view name_of(SubdivisionScheme) { return "catmull-clark"; }

std::string why_no_limit_surface(const Cage& cage) {
    if (std::string why = why_no_faces(cage); !why.empty()) return why;
    std::map<Edge, std::vector<int>> uses;
    for (int f = 0; f < std::ssize(cage.faces); ++f)
        for (std::size_t k = 0, n = cage.faces[f].size(); k < n; ++k) {
            const int a = cage.faces[f][k], b = cage.faces[f][(k + 1) % n];
            uses[sorted(a, b)].push_back(a < b ? f + 1 : -(f + 1));
        }
    if (std::string why = why_no_surface(cage, uses); !why.empty()) return why;
    return why_no_tags(cage, uses);
}

LimitSurface limit_surface(const Cage& cage, SubdivisionScheme) {
    if (const std::string why = why_no_limit_surface(cage); !why.empty()) throw std::invalid_argument(why);
    auto shared = std::make_shared<LimitPatch::Shared>();
    shared->refiner = refiner_of(cage);
    if (!shared->refiner) throw std::invalid_argument("the cage has no limit surface");
    using Factory = osd::Bfr::RefinerSurfaceFactory<>;
    Factory::Options options;
    options.SetApproxLevelSmooth(kLevels).SetApproxLevelSharp(kLevels);
    shared->factory = std::make_unique<const Factory>(*shared->refiner, options);

    std::vector<double> points;
    for (const Vector3d& p : cage.points) points.insert(points.end(), p.begin(), p.end());
    LimitSurface result;
    // Neighbours are to have whole sides in common.
    const bool all_quads = std::all_of(cage.faces.begin(), cage.faces.end(), [](const auto& face) { return face.size() == 4; });
    for (int f = 0; f < std::ssize(cage.faces); ++f) {
        auto surface = std::make_shared<LimitPatch::Surface>();
        if (!shared->factory->InitVertexSurface(f, surface.get())) continue;  // a hole, or at a boundary without a surface
        auto patch_points = std::make_shared<std::vector<double>>(3 * static_cast<std::size_t>(surface->GetNumPatchPoints()));
        surface->PreparePatchPoints(points.data(), 3, patch_points->data(), 3);
        const Parts parts = parts_of(surface->GetParameterization(), all_quads);
        for (const Vector2d& low : parts.low) {
            result.patches.push_back(std::make_unique<LimitPatch>(shared, surface, patch_points, low, parts.width));
            result.face.push_back(f);
        }
    }
    return result;
}

}  // namespace gradus
