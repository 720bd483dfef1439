#include "cages.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "describe.hpp"
#include "gradus/io/cage_files.hpp"
#include "gradus/mesh/edge.hpp"
#include "session.hpp"

namespace gradus::app {

namespace {

SubdivisionScheme scheme_of(const CageChoice& choice) {
    return choice.scheme == name_of(SubdivisionScheme::Loop) ? SubdivisionScheme::Loop
                                                             : SubdivisionScheme::CatmullClark;
}

}  // namespace

void add_cages(CLI::App& app, CageChoice& choice) {
    const std::string group = "Subdivision";
    app.add_option("--subdivision", choice.scheme, "IN is a cage, .obj: its limit surface is meant")
        ->type_name("catmull-clark|loop")
        ->check(CLI::IsMember({"catmull-clark", "loop"}).description(""))
        ->group(group);
    app.add_option("--cage-crease-angle", choice.crease_angle,
                   "Edges at which faces of the cage meet at this angle or more are sharp, degrees (default: those "
                   "that the file says)")
        ->type_name("DEG")
        ->check(CLI::Range(0.0, 180.0).description(""))
        ->group(group);
    app.add_option("--cage-boundary", choice.boundary,
                   "Boundaries: without a surface, ending in their curves, or with sharp corners too (default: as the "
                   "file says, else corners)")
        ->type_name("none|edges|corners")
        ->check(CLI::IsMember({"none", "edges", "corners"}).description(""))
        ->group(group);
}

void check(const CageChoice& choice) {
    if (choice.is_given()) return;
    if (choice.crease_angle) throw UsageError("--cage-crease-angle is for cages; give --subdivision too");
    if (!choice.boundary.empty()) throw UsageError("--cage-boundary is for cages; give --subdivision too");
}

LoadedModel load_limit_surface(const std::string& path, const CageChoice& choice, bool keeps_label_borders) {
    Cage cage = read_cage(path);
    const SubdivisionScheme scheme = scheme_of(choice);
    try {
        if (choice.crease_angle) {
            if (const std::string why = why_no_limit_surface(cage, scheme); !why.empty())
                throw Failure(path + ": " + why);
            sharpen(cage, *choice.crease_angle * std::numbers::pi / 180);
        }
        if (choice.boundary == "none") cage.boundary = Cage::Boundary::None;
        if (choice.boundary == "edges") cage.boundary = Cage::Boundary::Edges;
        if (choice.boundary == "corners") cage.boundary = Cage::Boundary::EdgesAndCorners;
        const std::vector<int> label = keeps_label_borders ? cage.labels : std::exchange(cage.labels, {});
        LimitSurface surface = limit_surface(cage, scheme);
        if (surface.topology.patches.empty())
            throw Failure(path + (cage.boundary == Cage::Boundary::None
                                      ? ": no face of the cage has a limit surface; --cage-boundary edges gives "
                                        "boundaries one"
                                      : ": all faces of the cage are holes"));
        std::vector<int> labels;
        for (const int face : surface.face)
            if (!label.empty()) labels.push_back(label[face]);
        return {SurfaceModel(std::move(surface.topology)), std::move(labels)};
    } catch (const std::invalid_argument& error) {
        throw Failure(path + ": " + error.what());
    }
}

namespace {

std::string counted(const std::map<int, int>& counts, std::string_view what) {
    std::vector<std::string> parts;
    for (const auto& [number, count] : counts) parts.push_back(fmt::format("{} of {}", count, number));
    return fmt::format("{} {}", fmt::join(parts, ", "), what);
}

}  // namespace

Description describe_cage(const std::string& path, const CageChoice& choice) {
    const Cage cage = read_cage(path);
    std::map<int, int> corners, valences;
    std::map<std::array<int, 2>, int> uses;
    for (const std::vector<int>& face : cage.faces) {
        ++corners[static_cast<int>(face.size())];
        for (std::size_t k = 0; k < face.size(); ++k) {
            ++uses[edge_between(face[k], face[(k + 1) % face.size()])];
        }
    }
    std::vector<int> valence(cage.points.size(), 0);
    for (const auto& [edge, count] : uses)
        for (const int v : edge)
            if (v >= 0 && v < std::ssize(valence)) ++valence[v];
    for (const int v : valence) ++valences[v];
    const auto boundary = std::count_if(uses.begin(), uses.end(), [](const auto& use) { return use.second == 1; });
    const auto sharp = std::count_if(cage.creases.begin(), cage.creases.end(),
                                     [](const Cage::Crease& crease) { return crease.sharpness >= Cage::kSharp; });
    const auto semisharp = std::ssize(cage.creases) - sharp;
    const std::string why = why_no_limit_surface(cage, scheme_of(choice));
    Description info;
    info.text = fmt::format("{}: cage, {} vertices, {} edges, {} faces\n", path, cage.points.size(), uses.size(),
                            cage.faces.size());
    info.text += "faces: " + counted(corners, "corners") + "\nvertices: " + counted(valences, "edges") + "\n";
    info.text += fmt::format("{} boundary edges, {} sharp and {} semi-sharp creases, {} corners, {} holes\n", boundary,
                             sharp, semisharp, cage.corners.size(), cage.holes.size());
    info.text += why.empty() ? fmt::format("has a limit surface by {}\n", choice.scheme)
                             : fmt::format("has NO limit surface by {}: {}\n", choice.scheme, why);
    info.json = {{"kind", "cage"},
                 {"vertices", cage.points.size()},
                 {"edges", uses.size()},
                 {"faces", cage.faces.size()},
                 {"boundary_edges", boundary},
                 {"sharp_creases", sharp},
                 {"semisharp_creases", semisharp},
                 {"corners", cage.corners.size()},
                 {"holes", cage.holes.size()},
                 {"limit_surface", why.empty()},
                 {"why_not", why}};
    for (const auto& [number, count] : corners) info.json["corners_of_faces"][std::to_string(number)] = count;
    for (const auto& [number, count] : valences) info.json["valences"][std::to_string(number)] = count;
    return info;
}

}  // namespace gradus::app
