#include "gradus/remesh/chord_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "curve_deviation.hpp"
#include "gradus/gradation/gradient.hpp"
#include "gradus/gradation/hold.hpp"

namespace gradus {

namespace {

using Eigen::Vector3d;

// -- Sizes to begin with --
constexpr double kShareOfEdges =
    0.4;  // of the chord error, for the gap over edges: triangles are farther off than their edges
constexpr double kLeastChordError = 1e-10;  // of the largest coordinate: distances much below are lost in rounding
constexpr double kMostTurn = std::numbers::pi / 3;  // of a curve no larger than the chord error, within one edge
constexpr double kShareOfBulge = 0.2;               // of the chord error, for the smooth surface over the triangulation

// -- When to stop --
constexpr int kMostDrafts = 3;
constexpr int kMostLowerings = 24;
constexpr int kMostAtOnePlace = 8;  // what eight times did not mend there, smaller sizes will not
constexpr int kStubborn = 3;        // places lowered this often may need features
constexpr int kSecondChances = 2;   // for places that lower sizes broke
constexpr int kMostInVain = 6;      // meshes in a row that are no better than those before
constexpr double kProgress = 0.95;  // of the smallest deviation so far: what counts as better
constexpr double kSampleShare =
    0.75;  // of the chord error, for the samples of drafts: what is nearly too far is too far after the final schedule
constexpr double kAsPrescribed =
    0.5;  // of the size that drafts have at prescribed points: what is missed is refined again
constexpr double kFewFar =
    0.01;  // of the triangles, that may be too far off in a draft: the final schedule changes as much

// -- How far to lower sizes --
constexpr double kGoal = 0.8;       // of the chord error: what just keeps it would not after the next smoothing
constexpr double kSteepest = 0.35;  // least factor: distances far above the limit say little
constexpr double kLeast = 0.8;      // largest factor: less of a change is none
constexpr double kPlace = 4;        // width of a place over the chord error
constexpr double kAtPlace = 1.5;    // sizes: how far around a place where elements are bad
// Of the length of frozen edges, and slope from there, down to which sizes go: edges of half that length still count as
// unit beside them.
constexpr double kLeastHeld = 0.6;
constexpr double kSameSize = 1e-6;  // relative: sizes that are not lowered by more are as they were

// The triangle of the surface under each vertex.
std::vector<int> triangles_under(std::span<const SurfacePoint> places) {
    std::vector<int> under;
    under.reserve(places.size());
    for (const SurfacePoint& at : places) under.push_back(at.patch);
    return under;
}

MeshView view_of(const SurfaceMesh& mesh) { return {mesh.points, mesh.triangles}; }

ReferenceView reference_of(const Triangulation& surface) {
    return {{surface.soup().points, surface.soup().triangles}, surface.mesh()};
}

// What holds of curves and edges, both ways.
void include(const OneSidedDistance& curves, Deviation& deviation) {
    for (OneSidedDistance* side : {&deviation.from_reference, &deviation.from_mesh}) {
        side->bound = std::max(side->bound, curves.bound);
        if (curves.largest <= side->largest) continue;
        side->largest = curves.largest;
        side->point = curves.point;
    }
}

// Counts the rounds in which something was done at each place, a cube of some width.
class RoundsAtPlaces {
  public:
    explicit RoundsAtPlaces(double width) : width_(width) {}

    void begin_round() { ++round_; }

    // Counts this round once, however often it is told of a place. @returns the number of rounds there, and whether
    // this one was counted now
    std::pair<int, bool> count(const Vector3d& p) {
        Rounds& rounds = at_[{std::lround(p.x() / width_), std::lround(p.y() / width_), std::lround(p.z() / width_)}];
        const bool is_first = rounds.last < round_;
        if (is_first) rounds = {round_, rounds.number + 1};
        return {rounds.number, is_first};
    }

  private:
    struct Rounds {
        int last = 0, number = 0;
    };
    int round_ = 0;
    double width_;
    std::map<std::array<long, 3>, Rounds> at_;
};

// Tells when meshes do not become better any more.
class Progress {
  public:
    // @returns false after too many meshes in a row with neither fewer triangles at fault nor a smaller deviation
    bool goes_on(std::size_t at_fault, double deviation) {
        const bool better = at_fault < fewest_ || deviation < kProgress * smallest_;
        fewest_ = std::min(fewest_, at_fault);
        smallest_ = std::min(smallest_, deviation);
        in_vain_ = better ? 0 : in_vain_ + 1;
        return in_vain_ < kMostInVain;
    }

  private:
    std::size_t fewest_ = std::numeric_limits<std::size_t>::max();
    double smallest_ = std::numeric_limits<double>::infinity();
    int in_vain_ = 0;
};

// Checks the meshes that remesh comes to, and says with what sizes to go on.
class ChordErrorCheck : public MeshChecks {
  public:
    using Sizes = std::optional<std::vector<double>>;  // nothing: the mesh is good, or there is no more to do

    // @param control  freed once it is not needed any more
    ChordErrorCheck(const Triangulation& surface, double chord_error, const ChordErrorOptions& options,
                    ChordErrorResult& made, std::unique_ptr<const ControlSpace>& control)
        : surface_(surface),
          chord_error_(chord_error),
          options_(options),
          made_(made),
          control_(control),
          contacts_(surface.soup()),
          lowered_at_(kPlace * chord_error) {}

    bool has_limit() const override { return std::isfinite(chord_error_); }

    std::vector<MeshFault> faults_of(const SurfaceMesh& mesh) override {
        if (options_.on_check) options_.on_check(mesh);
        if (!has_limit()) return {};
        proved_ = proof().prove(view_of(mesh), triangles_under(mesh.places));
        if (surface_.soup().dimension == 2) hold_curves(mesh);
        made_.deviation = proved_.deviation;
        made_.kept = proved_.deviation.bound() <= chord_error_;
        made_.faults.clear();
        std::vector<MeshFault> faults;
        for (const TooFar& f : proved_.at_fault) {
            // Those of one point of the surface are one after the other.
            const Vector3d p = closest_on_surface(f);
            if (faults.empty() || faults.back().point != p) faults.push_back({p, f.distance, {}});
            faults.back().distance = std::max(faults.back().distance, f.distance);
            faults.back().triangles.push_back(f.triangle);
        }
        for (const MeshFault& fault : faults) made_.faults.push_back(fault.point);
        return faults;
    }

    Sizes sizes_after(const SurfaceMesh& mesh, MeshStage stage, std::span<const Vector3d> in_vain) override {
        control_.reset();
        return stage == MeshStage::Draft ? after_draft(mesh) : after_final(mesh, in_vain);
    }

    std::vector<double> sizes_of_draft(const SurfaceMesh& mesh) override {
        std::vector<double> sizes = mesh.sizes;
        settle(mesh, sizes);
        return sizes;
    }

    Sizes sizes_below(const SurfaceMesh& mesh, std::span<const Vector3d> places, double factor) override {
        std::vector<double> sizes = mesh.sizes;
        bool any = false;
        for (std::size_t v = 0; v < sizes.size(); ++v) {
            const auto is_near = [&](const Vector3d& p) {
                return (p - mesh.points[v]).norm() < kAtPlace * mesh.sizes[v];
            };
            if (std::none_of(places.begin(), places.end(), is_near) || sizes[v] <= options_.hmin) continue;
            sizes[v] = std::max(factor * sizes[v], options_.hmin);
            any = true;
        }
        if (!any) return std::nullopt;
        before_ = {made_.map, made_.lowerings};
        progress_ = {};
        second_chances_ = kSecondChances;
        return go_on_with(mesh, std::move(sizes));
    }

    std::vector<Vector3d> contacts_of(const SurfaceMesh& mesh) override {
        made_.contacts = contacts_.of(view_of(mesh));
        std::vector<Vector3d> places;
        for (const NewContact& contact : made_.contacts.listed) places.push_back(contact.point);
        return places;
    }

    void take_back() override {
        made_.map = std::move(before_.map);
        made_.lowerings = before_.lowerings;
    }

    bool allows(const MeshPart& part) override {
        return !has_limit() || proof().is_kept_by({part.points, part.triangles}, part.changed,
                                                  triangles_under(part.places), part.fault);
    }

  private:
    // In the plane the surfaces are the same but for their outlines, so curves are held against curves.
    void hold_curves(const SurfaceMesh& mesh) {
        if (!curves_) curves_.emplace(surface_);
        const OneSidedDistance found = curves_->measure(mesh, chord_error_);
        include(found, proved_.deviation);
        proved_.at_fault.insert(proved_.at_fault.end(), found.beyond.begin(), found.beyond.end());
    }

    Vector3d closest_on_surface(const TooFar& f) const {
        const auto& points = surface_.soup().points;
        const Triangle& t = surface_.soup().triangles[f.nearest];
        return closest_point(f.point, points[t[0]], points[t[1]], points[t[2]]);
    }

    // Drafts are only sampled, and may have a few triangles that are too far off.
    Sizes after_draft(const SurfaceMesh& mesh) {
        if (options_.on_check) options_.on_check(mesh);
        if (made_.lowerings == kMostDrafts) return std::nullopt;
        const std::vector<TooFar> far =
            proof().target().sample_from(view_of(mesh), kSampleShare * chord_error_, triangles_under(mesh.places));
        const bool is_near = static_cast<double>(far.size()) <= kFewFar * static_cast<double>(mesh.triangles.size());
        if (is_near && has_prescribed(mesh)) return std::nullopt;
        if (auto sizes = lower_sizes(mesh, far, {})) return sizes;
        return is_near ? go_on_with(mesh, mesh.sizes) : std::nullopt;
    }

    Sizes after_final(const SurfaceMesh& mesh, std::span<const Vector3d> in_vain) {
        const std::vector<TooFar>& at_fault = proved_.at_fault;
        if (at_fault.empty() || !progress_.goes_on(at_fault.size(), proved_.deviation.bound())) return std::nullopt;
        if (auto sizes = lower_sizes(mesh, at_fault, in_vain)) return sizes;
        // What broke may not break again once all around it has changed.
        const std::pair chance(at_fault.size(), proved_.deviation.bound());
        if (in_vain.empty() || second_chances_ == 0 || std::exchange(last_chance_, chance) == chance)
            return std::nullopt;
        --second_chances_;
        return lower_sizes(mesh, at_fault, {});
    }

    // Made when it is asked for: the mesh that begins with the triangles of the surface has fewer by then.
    DeviationProof& proof() {
        if (!proof_) proof_.emplace(reference_of(surface_), chord_error_);
        return *proof_;
    }

    Sizes lower_sizes(const SurfaceMesh& mesh, std::span<const TooFar> far, std::span<const Vector3d> in_vain) {
        std::vector<double> sizes = mesh.sizes;
        if (!lower_at(mesh, far, in_vain, sizes)) return std::nullopt;
        return go_on_with(mesh, std::move(sizes));
    }

    // Sizes that were lowered, graded, unless that was done too often.
    Sizes go_on_with(const SurfaceMesh& mesh, std::vector<double> sizes) {
        if (made_.lowerings == kMostLowerings) return std::nullopt;
        if (!settle(mesh, sizes)) return std::nullopt;
        ++made_.lowerings;
        return sizes;
    }

    // Makes sizes what they are to be beside each other, at prescribed points and at frozen edges. @returns false where
    // that left nothing lower
    bool settle(const SurfaceMesh& mesh, std::vector<double>& sizes) {
        lower_to_prescribed(options_.prescribed, mesh.points, sizes);
        if (options_.gradation) grade_again(mesh, sizes);
        std::vector<double> graded = sizes;
        if (!mesh.required.empty() && !hold_frozen(mesh, sizes)) return false;
        if (options_.gradation) made_.map = {mesh.points, mesh.triangles, std::move(graded)};
        return true;
    }

    // Whether each prescribed size is about what the mesh has there.
    bool has_prescribed(const SurfaceMesh& mesh) const {
        std::vector<double> sizes = mesh.sizes;
        lower_to_prescribed(options_.prescribed, mesh.points, sizes);
        for (std::size_t v = 0; v < sizes.size(); ++v)
            if (sizes[v] < kAsPrescribed * mesh.sizes[v]) return false;
        return true;
    }

    // At the corners of triangles that are too far off. @returns whether any size was lowered
    bool lower_at(const SurfaceMesh& mesh, std::span<const TooFar> far, std::span<const Vector3d> in_vain,
                  std::vector<double>& sizes) {
        bool any = false;
        lowered_at_.begin_round();
        for (const TooFar& f : far) {
            const Triangle& corners = mesh.triangles[f.triangle];
            if (is_around(mesh.points[corners[0]], mesh.sizes[corners[0]], in_vain)) continue;
            const auto [times, is_first] = lowered_at_.count(f.point);
            if (times > kMostAtOnePlace) continue;
            if (times == kStubborn && is_first) made_.stubborn.push_back(closest_on_surface(f));
            const double factor = factor_for(f.distance, times);
            for (const int v : corners) {
                const double size = std::max(factor * mesh.sizes[v], options_.hmin);
                if (size < sizes[v]) sizes[v] = size, any = true;
            }
        }
        return any;
    }

    // Gaps fall with the square of the size on smooth parts, and with the size itself on sharp ones, where that did not
    // do.
    double factor_for(double distance, int times) const {
        const double power = times == 1 || made_.lowerings < kMostDrafts ? 0.5 : 1;
        return std::clamp(std::pow(kGoal * chord_error_ / std::max(distance, chord_error_), power), kSteepest, kLeast);
    }

    // A bound on triangles holds on their edges too, so Full needs no more, and no TriMesh, which takes long to build.
    void grade_again(const SurfaceMesh& mesh, std::vector<double>& sizes) const {
        const GradationOptions& gradation = *options_.gradation;
        if (gradation.method == GradationMethod::Full)
            limit_gradient(mesh.points, mesh.triangles, gradient_bound(gradation), sizes);
        else
            grade(make_mesh(mesh.points, mesh.triangles), sizes, gradation);
    }

    // Raises sizes beside frozen edges, where smaller elements are no way out. @returns whether any is still below that
    // of the mesh
    static bool hold_frozen(const SurfaceMesh& mesh, std::vector<double>& sizes) {
        const Connectivity connectivity(static_cast<int>(mesh.points.size()), mesh.triangles);
        std::vector<double> held =
            frozen_edge_lengths(mesh.points, connectivity, frozen_elements(mesh.points, connectivity, mesh.required));
        for (double& length : held) length *= kLeastHeld;
        raise_to_held(make_mesh(mesh.points, mesh.triangles), held, kLeastHeld, sizes);
        return !std::equal(sizes.begin(), sizes.end(), mesh.sizes.begin(),
                           [](double now, double before) { return now > (1 - kSameSize) * before; });
    }

    const Triangulation& surface_;
    double chord_error_;
    const ChordErrorOptions& options_;
    ChordErrorResult& made_;
    std::unique_ptr<const ControlSpace>& control_;
    std::optional<DeviationProof> proof_;
    std::optional<CurveDeviation> curves_;
    ContactFinder contacts_;
    ProvedDeviation proved_;  // of the last mesh
    Progress progress_;
    RoundsAtPlaces lowered_at_;
    int second_chances_ = kSecondChances;
    std::pair<std::size_t, double> last_chance_;  // triangles at fault then, and the deviation
    struct {
        std::optional<LoweredMap> map;
        int lowerings = 0;
    } before_;  // sizes_below
};

void check_arguments(const Triangulation& surface, double chord_error, const ChordErrorOptions& options) {
    const double least = least_chord_error(surface.soup().points);
    if (chord_error > 0 && chord_error < least)
        throw std::invalid_argument(fmt::format(
            "remesh_within: chord error is {:g}, below {:.3g}, what distances are rounded to", chord_error, least));
    if (!(chord_error > 0))
        throw std::invalid_argument("remesh_within: chord error is " + std::to_string(chord_error) + ", not above 0");
    if (!(options.hmin >= 0))
        throw std::invalid_argument("remesh_within: hmin is " + std::to_string(options.hmin) + ", below 0");
    if (!options.gradation) return;
    gradient_bound(*options.gradation);  // throws for bad bounds
    if (!options.gradation->required.empty())
        throw std::invalid_argument(
            "remesh_within: sizes are required at vertices of the map, which later meshes do not have");
}

}  // namespace

double least_chord_error(std::span<const Vector3d> points) {
    double largest = 0;
    for (const Vector3d& p : points) largest = std::max(largest, p.cwiseAbs().maxCoeff());
    return kLeastChordError * largest;
}

SizingRule rule_within(double chord_error, SizingRule rule) {
    rule.kind = SizingRule::Kind::ChordError;
    rule.value = kShareOfEdges * chord_error;
    rule.most_turn = kMostTurn;
    return rule;
}

ChordErrorResult remesh_within(const Triangulation& surface, TriangulationBackground map, double chord_error,
                               const ChordErrorOptions& options) {
    check_arguments(surface, chord_error, options);
    ChordErrorResult made;
    auto control = std::make_unique<const ControlSpace>(map.background, map.sizes);
    // Large, and of no use any more: the mesh of the background, and its sizes once there are others.
    map.background.mesh = {};
    map.sizes = {};
    ChordErrorCheck checks(surface, chord_error, options, made, control);
    const SmoothSupport support = surface.support({.largest_bulge = kShareOfBulge * chord_error});
    made.result = remesh({support, surface.features(), surface.soup().labels, &surface.soup().required}, *control,
                         map.cells, options.remesh, &checks);
    if (!checks.has_limit()) made.kept = true;
    SurfaceMesh& mesh = made.result.mesh;
    mesh.dimension = surface.soup().dimension;
    if (mesh.dimension == 2)
        for (Eigen::Vector3d& p : mesh.points) p.z() = 0;  // was, to rounding
    return made;
}

Deviation measure_deviation(const Triangulation& surface, const SurfaceMesh& mesh) {
    Deviation deviation = measure_deviation(reference_of(surface), view_of(mesh), triangles_under(mesh.places));
    if (surface.soup().dimension == 2)
        include(CurveDeviation(surface).measure(mesh, std::numeric_limits<double>::infinity()), deviation);
    return deviation;
}

}  // namespace gradus
