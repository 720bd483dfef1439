#include "files.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <utility>

#include "gradus/io/mesh_files.hpp"
#include "gradus/io/patch_files.hpp"
#include "gradus/io/size_view.hpp"
#include "gradus/mesh/diagnose.hpp"

namespace gradus::app {

namespace fs = std::filesystem;

namespace {

constexpr double kTurned = 0.9;  // cosine of the turn of a triangle by rounding, 26 degrees

std::string extensions_of(FileKind kind) {
    switch (kind) {
        case FileKind::Patches:
            return ".bpt .bez";
        case FileKind::Mesh:
            return ".obj .off .ply .stl .mesh .meshb .msh .vtu";
        case FileKind::ReadMesh:
            return ".vtp .poly";
        case FileKind::Sizes:
            return ".sol .solb";
        case FileKind::SizeView:
            return ".pos";
        case FileKind::SizedMesh:
            return ".msh .vtu .ply";
        case FileKind::Report:
            return ".html .json";
        case FileKind::Unknown:
            break;
    }
    return "";
}

bool is_of(const std::string& path, FileKind kind) {
    const std::string extension = extension_of(path);
    return !extension.empty() && (extensions_of(kind) + " ").find(extension + " ") != std::string::npos;
}

void check_folder(const std::string& path, const fs::path& folder) {
    std::error_code none;
    if (!fs::exists(folder, none)) throw Failure(path + ": there is no folder " + folder.string() + "; make it first");
    if (!fs::is_directory(folder, none)) throw Failure(path + ": " + folder.string() + " is no folder");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        throw Failure(path + ": folder " + folder.string() + " cannot be written into; choose another");
}

}  // namespace

std::string extension_of(const std::string& path) {
    std::string extension = fs::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

FileKind kind_of(const std::string& path) {
    for (const FileKind kind :
         {FileKind::Patches, FileKind::Mesh, FileKind::ReadMesh, FileKind::Sizes, FileKind::SizeView, FileKind::Report})
        if (is_of(path, kind)) return kind;
    return FileKind::Unknown;
}

std::string with_extension(const std::string& path, const std::string& extension) {
    return fs::path(path).replace_extension(extension).string();
}

void check_output(const std::string& path, const std::vector<FileKind>& kinds) {
    if (path.empty()) throw UsageError("an output has no name");
    if (std::none_of(kinds.begin(), kinds.end(), [&](FileKind kind) { return is_of(path, kind); })) {
        std::string known;
        for (const FileKind kind : kinds) known.append(" ").append(extensions_of(kind));
        throw UsageError(path + ": unknown extension \"" + extension_of(path) + "\"; use one of" + known);
    }
    std::error_code none;
    if (fs::is_directory(path, none)) throw Failure(path + ": is a folder, not a file");
    // What is no regular file (a pipe) is written directly, anything else by way of its folder.
    if (fs::exists(path, none) && ::access(path.c_str(), W_OK) != 0)
        throw Failure(path + ": is write-protected; choose another name");
    if (fs::exists(path, none) && !fs::is_regular_file(path, none)) return;
    const fs::path folder = fs::path(path).parent_path();
    check_folder(path, folder.empty() ? fs::path(".") : folder);
}

void make_folder(const std::string& path) {
    std::error_code error;
    fs::create_directories(path, error);
    if (error) throw Failure(path + ": this folder cannot be made: " + error.message());
    check_folder(path, path);
}

void check_distinct(const std::vector<std::string>& outputs) {
    std::vector<std::string> names;
    for (const std::string& path : outputs) {
        std::error_code none;
        const std::string name = fs::weakly_canonical(fs::absolute(path), none).string();
        if (std::find(names.begin(), names.end(), name) != names.end())
            throw UsageError(path + ": is named for two outputs");
        names.push_back(name);
    }
}

LoadedModel load_model(const std::string& path, const CageChoice& cage, bool keeps_label_borders) {
    if (cage.is_given()) return load_limit_surface(path, cage, keeps_label_borders);
    if (kind_of(path) != FileKind::Patches)
        throw UsageError(path + ": unknown extension \"" + extension_of(path) + "\"; surfaces are read from " +
                         extensions_of(FileKind::Patches) + " " + extensions_of(FileKind::Mesh) + " " +
                         extensions_of(FileKind::ReadMesh));
    const PatchFile file = read_patches(path);
    try {
        return {make_model(file)};
    } catch (const std::invalid_argument& error) {
        throw Failure(path + ": " + error.what());
    }
}

Repaired repaired_by_default(const std::string& path, const TriangleSoup& soup, const Session& session) {
    const RepairOptions options = default_repair(soup);
    if (options.weld_tolerance > 0)
        session.say(fmt::format("{}: vertices at open edges within {:.3g} of the diagonal are taken for one\n", path,
                                options.weld_tolerance));
    return repair(soup, options);
}

void weld_read(const std::string& path, TriangleSoup& soup, const Session& session) {
    if (extension_of(path) != ".stl") return;
    if (const int gone = weld_roundings(soup); gone > 0)
        session.say(fmt::format("{}: {} vertices a rounding from others are taken for these\n", path, grouped(gone)));
}

TriangleSoup sound(const std::string& path, TriangleSoup soup, bool repair, const Session& session) {
    if (repair) {
        Repaired repaired = repaired_by_default(path, soup, session);
        session.say(text_of(path, repaired));
        return std::move(repaired.soup);
    }
    const Diagnosis diagnosis = diagnose(soup);
    if (const std::string reasons = why_not_manifold(diagnosis); !reasons.empty())
        throw Failure(path + ": not an oriented manifold: " + reasons + "; try --repair");
    if (const Cracks cracks = diagnosis.closed || soup.dimension == 2 ? Cracks{} : find_cracks(soup); !cracks.empty())
        session.warn(fmt::format("{}: {}, which --repair closes", path, text_of(cracks)));
    return soup;
}

std::string text_of(const Cracks& cracks) {
    std::string text;
    if (cracks.twins > 0) text = fmt::format("{} vertices at open edges lie on others (cracks)", grouped(cracks.twins));
    if (cracks.twins > 0 && cracks.junctions > 0) text += ", ";
    if (cracks.junctions > 0)
        text += fmt::format("{} vertices lie within open edges (T-junctions)", grouped(cracks.junctions));
    return text;
}

std::string text_of(const std::string& path, const Repaired& repaired) {
    if (repaired.steps.empty()) return path + ": nothing to repair\n";
    std::istringstream lines(summary(repaired.steps));
    std::string text = path + " repaired:\n";
    for (std::string line; std::getline(lines, line);) text += "  " + line + "\n";
    return text;
}

TriMesh manifold_of(const std::string& path, const TriangleSoup& soup) {
    try {
        return to_mesh(soup);
    } catch (const std::invalid_argument&) {
        throw Failure(path + ": not an oriented manifold mesh; gradus info " + path + " says where");
    }
}

Background load_background(const std::string& path, const SurfaceModel& model) {
    const TriangleSoup soup = read_mesh(path);
    try {
        return background_from_soup(model, soup);
    } catch (const std::invalid_argument& error) {
        throw Failure(path + ": not a background mesh of this surface: " + error.what());
    }
}

bool holds_mesh(const std::string& size_map) { return is_of(size_map, FileKind::SizedMesh); }

void write_size_map(const std::string& path, const TriangleSoup& soup, const std::vector<double>& sizes) {
    const std::string extension = extension_of(path);
    if (extension == ".pos" || extension == ".msh")
        write_size_view(path, soup, sizes);
    else if (extension == ".vtu")
        write_mesh_data(path, {.soup = soup, .point_fields = {{.name = "size", .components = 1, .values = sizes}}});
    else if (extension == ".ply")
        write_coloured_ply(path, soup.points, soup.triangles, sizes, {.scale = Scale::Logarithmic});
    else
        write_sizes(path, sizes, soup.dimension);
}

void check_holds(const std::string& path, std::span<const Eigen::Vector3d> points,
                 std::span<const Triangle> triangles) {
    if (extension_of(path) != ".stl") return;
    const auto beyond = std::find_if(points.begin(), points.end(),
                                     [](const Eigen::Vector3d& p) { return !p.cast<float>().allFinite(); });
    if (beyond != points.end())
        throw Failure(fmt::format("{}: vertex {} is beyond single precision, which binary STL is limited to", path,
                                  beyond - points.begin() + 1));
    const auto normal = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                           const Eigen::Vector3d& c) -> Eigen::Vector3d {
        return (b - a).cross(c - a).stableNormalized();
    };
    std::vector<Eigen::Vector3d> rounded;
    for (const Eigen::Vector3d& p : points)
        rounded.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
    const auto is_lost = [&](const Triangle& t) {
        const Eigen::Vector3d exact = normal(points[t[0]], points[t[1]], points[t[2]]);
        return !exact.isZero() && normal(rounded[t[0]], rounded[t[1]], rounded[t[2]]).dot(exact) < kTurned;
    };
    if (const auto lost = std::count_if(triangles.begin(), triangles.end(), is_lost); lost > 0)
        throw Failure(
            fmt::format("{}: binary STL has single precision, in which {} triangles would be flattened or turned, this "
                        "far from the origin; "
                        "write .obj .off .ply or .mesh, or move the surface to the origin",
                        path, grouped(static_cast<long long>(lost))));
}

std::vector<std::string> labels_left_behind(bool has_labels, const std::vector<std::string>& outputs) {
    std::vector<std::string> notes;
    for (const std::string& path : outputs)
        if (has_labels && !holds_labels(path))
            notes.push_back(
                fmt::format("its labels are left behind, {} can hold none; .mesh .msh .ply .vtu can", path));
    return notes;
}

void require_reached(const std::string& size_map, std::span<const double> graded) {
    const auto unset = std::count_if(graded.begin(), graded.end(), [](double h) { return !std::isfinite(h); });
    if (unset > 0)
        throw Failure(fmt::format("{}: {} vertices have no size, in parts of the surface where no vertex has one",
                                  size_map, unset));
}

std::string background_beside(const std::string& sizes) {
    return with_extension(sizes, extension_of(sizes) == ".solb" ? ".meshb" : ".mesh");
}

}  // namespace gradus::app
