#include "triangulated.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "files.hpp"
#include "gradus/io/mesh_files.hpp"
#include "gradus/io/required_file.hpp"
#include "gradus/mesh/closest.hpp"
#include "gradus/mesh/diagnose.hpp"
#include "gradus/mesh/labels.hpp"
#include "gradus/mesh/order.hpp"
#include "gradus/mesh/parts.hpp"
#include "gradus/remesh/triangulation_for.hpp"

namespace gradus::app {

namespace {

constexpr double kAtLeast = 1.05;                       // of the least size: as small as elements may be
constexpr double kExplained = 2, kWorthTelling = 1e-4;  // of the sag that elements explain; of the diagonal
constexpr std::size_t kContactsTold = 3, kPartsTold = 5;

template <class Item>
void append(std::vector<Item>& to, const std::vector<Item>& items) {
    to.insert(to.end(), items.begin(), items.end());
}

// What the options require besides the file itself.
void add_required(const std::string& path, const TriangulationChoice& choice, TriangleSoup& soup) {
    RequiredElements& required = soup.required;
    std::set<int> known(required.triangles.begin(), required.triangles.end());
    for (const int label : choice.freeze) {
        bool found = false;
        for (int t = 0; t < std::ssize(soup.labels); ++t) {
            if (soup.labels[t] != label) continue;
            found = true;
            if (known.insert(t).second) required.triangles.push_back(t);
        }
        if (!found)
            throw Failure(
                fmt::format("{}: --freeze {}: no triangle has that label; {}", path, label, labels_there(soup.labels)));
    }
    if (choice.freeze_list.empty()) return;
    const RequiredElements list = read_required(choice.freeze_list, soup.points.size(), soup.triangles.size());
    append(required.vertices, list.vertices);
    append(required.edges, list.edges);
    for (const int t : list.triangles)
        if (known.insert(t).second) required.triangles.push_back(t);
}

}  // namespace

void add_triangulation(CLI::App& app, TriangulationChoice& choice) {
    const std::string group = "Triangulations";
    app.add_option("--feature-angle", choice.feature_angle,
                   "Angle between facets from which their edge is a crease, degrees (default: 40, and 55 where a round "
                   "is sampled coarsely)")
        ->type_name("DEG")
        ->check(CLI::Range(1.0, 180.0).description(""))
        ->group(group);
    app.add_flag("--no-label-borders", choice.no_label_borders, "Borders between labels are no features")->group(group);
    app.add_flag("--repair", choice.repair, "Repair what is no oriented manifold, and say each change")->group(group);
    app.add_option("--freeze", choice.freeze,
                   "Keep the triangles of a label as they are, as RequiredTriangles of .mesh; may be repeated "
                   "(RequiredVertices and "
                   "RequiredEdges are kept too; Ridges are divided anew)")
        ->type_name("LABEL")
        ->type_size(1)
        ->allow_extra_args(false)
        ->take_all()
        ->group(group);
    app.add_option("--freeze-list", choice.freeze_list,
                   "Keep what the lines of a text name: \"vertex I\", \"edge I J\", \"triangle I\", from 1 on")
        ->type_name("LIST")
        ->group(group);
}

void check_for_patches(const TriangulationChoice& choice) {
    const std::pair<bool, const char*> given[] = {{!choice.freeze.empty(), "--freeze"},
                                                  {!choice.freeze_list.empty(), "--freeze-list"},
                                                  {choice.repair, "--repair"},
                                                  {choice.feature_angle.has_value(), "--feature-angle"}};
    for (const auto& [is_given, option] : given)
        if (is_given) throw UsageError(std::string(option) + " is for triangle meshes, not for patches");
}

namespace {

TriangleSoup load_soup(const std::string& path, const TriangulationChoice& choice, const Session& session) {
    TriangleSoup soup = read_mesh(path);
    weld_read(path, soup, session);
    add_required(path, choice, soup);
    soup = sound(path, std::move(soup), choice.repair, session);
    if (soup.triangles.empty()) throw Failure(path + ": holds no triangles");
    return soup;
}

std::unique_ptr<Triangulation> triangulation_of(const std::string& path, TriangleSoup soup,
                                                const TriangulationChoice& choice, const SizingOptions& sizing) {
    const TriangulationOptions options = triangulation_options(choice);
    const double diagonal = diagonal_of(soup);
    try {
        return triangulation_for(std::move(soup), rule_of(sizing, limits_for(diagonal)), options);
    } catch (const std::invalid_argument& error) {
        throw Failure(path + ": " + error.what());
    }
}

}  // namespace

TriangulationOptions triangulation_options(const TriangulationChoice& choice) {
    TriangulationOptions options;
    if (choice.feature_angle) {
        if (std::isnan(*choice.feature_angle)) throw UsageError("--feature-angle nan: not a number");
        FeatureOptions& features = options.features;
        features.angle = features.sharp_angle = features.weak_angle = features.ridge_angle =
            *choice.feature_angle * std::numbers::pi / 180;
        features.all_from_angle = true;
    }
    options.label_borders = !choice.no_label_borders;
    return options;
}

std::unique_ptr<Triangulation> load_triangulation(const std::string& path, const TriangulationChoice& choice,
                                                  const SizingOptions& sizing, const Session& session) {
    return triangulation_of(path, load_soup(path, choice, session), choice, sizing);
}

OrderedTriangulation load_ordered(const std::string& path, const TriangulationChoice& choice,
                                  const SizingOptions& sizing, const Session& session) {
    TriangleSoup soup = load_soup(path, choice, session);
    const bool names_elements = !soup.required.empty() || !soup.edges.empty() || !soup.corners.empty();
    Ordered ordered = names_elements ? as_it_is(std::move(soup)) : along_curve(std::move(soup));
    return {triangulation_of(path, std::move(ordered.soup), choice, sizing), std::move(ordered.point_source),
            std::move(ordered.triangle_source)};
}

GivenSizes read_given_sizes(const std::string& sizes, const std::string& background, const Triangulation& surface) {
    if (background.empty()) return {.sizes = read_sizes(sizes, surface.soup().points.size()), .path = sizes};
    TriangleSoup mesh = read_mesh(background);
    if (const std::string reasons = why_not_manifold(diagnose(mesh)); !reasons.empty())
        throw Failure(background + ": not an oriented manifold: " + reasons);
    std::vector<double> read = read_sizes(sizes, mesh.points.size());
    return {std::move(read), std::move(mesh), sizes, background};
}

TriangulationBackground given_background(const Triangulation& surface, const GivenSizes& given) {
    if (!given.background) return make_background(surface, given.sizes);
    try {
        return make_background(surface, *given.background, given.sizes);
    } catch (const std::invalid_argument& error) {
        throw Failure(given.background_path + ": " + error.what());
    }
}

namespace {

// The place where the two surfaces are seen to be farthest from each other, and how far that is.
std::pair<Eigen::Vector3d, double> farthest_place(const Deviation& deviation) {
    const OneSidedDistance& farther =
        deviation.from_mesh.largest > deviation.from_reference.largest ? deviation.from_mesh : deviation.from_reference;
    return {farther.point, farther.largest};
}

int nearest_triangle(std::span<const Eigen::Vector3d> points, std::span<const Triangle> triangles,
                     const Eigen::Vector3d& place) {
    const auto distance2 = [&](const Triangle& t) {
        return (closest_point(place, points[t[0]], points[t[1]], points[t[2]]) - place).squaredNorm();
    };
    const auto nearest =
        std::min_element(triangles.begin(), triangles.end(),
                         [&](const Triangle& s, const Triangle& t) { return distance2(s) < distance2(t); });
    return static_cast<int>(nearest - triangles.begin());
}

// How far a triangle of the mesh near a place may be from the surface as that is curved there: its edges squared over
// eight radii, and the same of the facet of the input, which has its width from facet to facet.
double sag_near(const Triangulation& surface, const SurfaceMesh& mesh, const Eigen::Vector3d& place) {
    const std::vector<Eigen::Vector3d>& points = surface.soup().points;
    const Triangle& element = mesh.triangles[nearest_triangle(mesh.points, mesh.triangles, place)];
    const int facet = nearest_triangle(points, surface.soup().triangles, place);
    double curvature = 0, longest = 0, side = 0;
    for (int k = 0; k < 3; ++k) {
        const int h = 3 * facet + k, v = surface.mesh().origin(h);
        curvature = std::max({curvature, surface.corner_curvature()[h], surface.curve_curvature()[v]});
        longest = std::max(longest, (mesh.points[element[(k + 1) % 3]] - mesh.points[element[k]]).norm());
        side = std::max(side, (points[surface.mesh().target(h)] - points[v]).norm());
    }
    const Triangle& t = surface.soup().triangles[facet];
    const double width = side > 0 ? (points[t[1]] - points[t[0]]).cross(points[t[2]] - points[t[0]]).norm() / side : 0;
    return (longest * longest + width * width) * curvature / 8;
}

}  // namespace

std::string why_not_kept(const Triangulation& surface, const TriangulationMesh& mesh) {
    const std::pair<Eigen::Vector3d, double> farthest = farthest_place(mesh.deviation);
    const Eigen::Vector3d& place = farthest.first;
    const double distance = farthest.second;
    if (distance <= *mesh.chord_error) return "; the distance could not be bounded";
    const SurfaceMesh& m = mesh.result.mesh;
    const std::size_t v = nearest_point(m.points, place);
    std::string text = fmt::format(", by {:.3g} at {:.6g} {:.6g} {:.6g}", distance, place.x(), place.y(), place.z());
    if (mesh.least_size && m.sizes[v] <= kAtLeast * *mesh.least_size)
        return text + fmt::format(", where --hmin {:g} allows no smaller elements", *mesh.least_size);
    const auto is_near = [&](const std::array<int, 2>& edge) {
        const Eigen::Vector3d &a = surface.soup().points[edge[0]], &b = surface.soup().points[edge[1]];
        return (closest_point(place, a, b, b) - place).norm() < m.sizes[v];
    };
    const std::vector<std::array<int, 2>> edges = surface.features().edges();
    if (std::any_of(edges.begin(), edges.end(), is_near)) return text + ", beside a feature curve";
    return text + ", where the surface is folded or rough";
}

std::vector<std::string> notes_on(const Triangulation& surface, const TriangulationMesh& mesh) {
    std::vector<std::string> notes;
    const std::vector<Eigen::Vector3d>& points = surface.soup().points;
    if (mesh.least_size) {
        const std::vector<int> part = connected_parts(points.size(), surface.soup().triangles);
        std::map<int, std::size_t> small;  // by part: a vertex of it
        for (std::size_t v = 0; v < points.size(); ++v)
            if (surface.mesh().is_live_vertex(static_cast<int>(v)) &&
                surface.part_share()[v] * surface.diagonal() < *mesh.least_size)
                small.emplace(part[v], v);
        for (const auto& [number, v] : small) {
            if (notes.size() == kPartsTold) {
                notes.push_back(
                    fmt::format("{} more parts are smaller than --hmin", grouped(small.size() - notes.size())));
                break;
            }
            notes.push_back(fmt::format(
                "the part at {:.6g} {:.6g} {:.6g}, of a diagonal of {:.3g}, is smaller than --hmin {:g}", points[v].x(),
                points[v].y(), points[v].z(), surface.part_share()[v] * surface.diagonal(), *mesh.least_size));
        }
    }
    if (mesh.chord_error) return notes;
    const SurfaceMesh& m = mesh.result.mesh;
    const auto [place, distance] = farthest_place(mesh.deviation);
    if (distance <= kWorthTelling * surface.diagonal()) return notes;
    const double explained = sag_near(surface, m, place);
    if (distance > kExplained * explained)
        notes.push_back(
            fmt::format("the mesh is {:.3g} from it at {:.6g} {:.6g} {:.6g}, where its elements explain {:.3g}; "
                        "--chord-error bounds that",
                        distance, place.x(), place.y(), place.z(), explained));
    return notes;
}

std::string text_of(const std::string& path, const Triangulation& surface) {
    std::size_t edges = 0;
    for (const FeatureChain& chain : surface.features().chains) edges += chain.num_edges();
    const auto corners = std::count(surface.features().corner.begin(), surface.features().corner.end(), 1);
    return fmt::format("{}: {} triangles, {} vertices, diagonal {:.4g}; {} feature curves of {} edges, {} corners\n",
                       path, grouped(surface.soup().triangles.size()), grouped(surface.soup().points.size()),
                       surface.diagonal(), grouped(surface.features().chains.size()), grouped(edges),
                       grouped(static_cast<long long>(corners)));
}

std::string text_of(const TriangulationMesh& mesh, double diagonal) {
    const Deviation& d = mesh.deviation;
    std::string text =
        fmt::format("distance: at most {:.4g} from the input to the mesh, {:.4g} back ({:.3g} of the diagonal)",
                    d.from_reference.bound, d.from_mesh.bound, d.bound() / diagonal);
    if (mesh.chord_error)
        text += fmt::format("; {:.4g} asked for, {}, sizes lowered {} times", *mesh.chord_error,
                            mesh.kept ? "kept" : "NOT kept", mesh.refinements);
    text += "\n";
    if (!mesh.chord_error && mesh.refinements > 0)
        text +=
            fmt::format("sizes were lowered {} times, around elements that fell short or touched\n", mesh.refinements);
    if (mesh.contacts.count > 0) {
        text += fmt::format("contacts: {} pairs of triangles touch or intersect that do not in the input",
                            grouped(mesh.contacts.count));
        for (std::size_t i = 0; i < std::min(kContactsTold, mesh.contacts.listed.size()); ++i) {
            const Eigen::Vector3d& p = mesh.contacts.listed[i].point;
            text += fmt::format("{} {:.6g} {:.6g} {:.6g}", i == 0 ? ", at" : ";", p.x(), p.y(), p.z());
        }
        text += "\n";
    }
    for (const auto& [at, distance] : mesh.moved)
        text += fmt::format(
            "the size {:.4g} at {:.6g} {:.6g} {:.6g} holds {:.4g} from there, at the nearest vertex of the "
            "background\n",
            at.size, at.point.x(), at.point.y(), at.point.z(), distance);
    return text;
}

std::string text_of(const RequiredElements& required, const std::vector<std::string>& outputs) {
    if (required.empty()) return "";
    std::string text = fmt::format("frozen: {} vertices, {} edges, {} triangles are in the mesh as they were",
                                   grouped(required.vertices.size()), grouped(required.edges.size()),
                                   grouped(required.triangles.size()));
    for (const std::string& path : outputs)
        if (!marks_required(path)) text += fmt::format("; {} does not mark them, .mesh and .meshb do", path);
    return text + "\n";
}

Json json_of(const Triangulation& surface) {
    return {{"input_triangles", surface.soup().triangles.size()},
            {"input_vertices", surface.soup().points.size()},
            {"diagonal", surface.diagonal()},
            {"feature_curves", surface.features().chains.size()},
            {"required", json_of(surface.soup().required)},
            {"corners", std::count(surface.features().corner.begin(), surface.features().corner.end(), 1)}};
}

Json json_of(const TriangulationMesh& mesh) {
    // With a chord error that is kept nothing farther was looked for, and no distance is known to be attained.
    const auto side = [](const OneSidedDistance& d) {
        const bool attained = d.largest > 0 || d.bound == 0;
        return Json{{"largest", attained ? Json(d.largest) : Json(nullptr)},
                    {"bound", d.bound},
                    {"at", attained ? Json{d.point.x(), d.point.y(), d.point.z()} : Json(nullptr)}};
    };
    Json contacts = Json::array();
    for (const NewContact& contact : mesh.contacts.listed)
        contacts.push_back({contact.point.x(), contact.point.y(), contact.point.z()});
    return {{"distance",
             {{"from_input", side(mesh.deviation.from_reference)}, {"from_mesh", side(mesh.deviation.from_mesh)}}},
            {"chord_error", mesh.chord_error ? Json(*mesh.chord_error) : Json(nullptr)},
            {"new_contacts", {{"count", mesh.contacts.count}, {"first", contacts}}},
            {"chord_error_kept", mesh.chord_error ? Json(mesh.kept) : Json(nullptr)},
            {"refinements", mesh.refinements}};
}

MeshReport measure_surface_mesh(const TriangulationMesh& mesh) {
    const SurfaceMesh& m = mesh.result.mesh;
    const KnownFeatures features{.edges = m.features};
    return measure({m.points, m.triangles}, {.sizes = m.sizes, .features = &features, .required = &m.required});
}

}  // namespace gradus::app
