#include "gradus/io/size_view.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "bytes.hpp"
#include "formats.hpp"
#include "gradus/io/error.hpp"
#include "gradus/io/output_file.hpp"
#include "scanner.hpp"
#include "text_writer.hpp"

namespace gradus {
namespace {

/// What Gmsh has as the greatest size where none is given.
constexpr double kNoLimit = 1e22;

std::vector<double> finite_sizes(std::span<const double> sizes, std::size_t num_points) {
    if (sizes.size() != num_points)
        throw std::invalid_argument("write_size_view: " + std::to_string(sizes.size()) + " sizes for " +
                                    std::to_string(num_points) + " vertices");
    std::vector<double> finite(sizes.begin(), sizes.end());
    for (std::size_t i = 0; i < finite.size(); ++i) {
        if (!(finite[i] > 0))
            throw std::invalid_argument("write_size_view: the size of vertex " + std::to_string(i) + " is " +
                                        std::to_string(finite[i]) + ", but must be > 0");
        finite[i] = std::min(finite[i], kNoLimit);
    }
    return finite;
}

std::string pos_text(const TriangleSoup& soup, const std::vector<double>& sizes) {
    io::TextWriter out(256 * soup.triangles.size() + 64);
    out << "View \"size\" {\n";
    for (const Triangle& triangle : soup.triangles) {
        out << "ST(";
        for (std::size_t i = 0; i < 9; ++i)
            out << (i == 0 ? "" : ",")
                << soup.points[static_cast<std::size_t>(triangle[i / 3])][static_cast<int>(i % 3)];
        out << "){";
        for (std::size_t i = 0; i < 3; ++i) out << (i == 0 ? "" : ",") << sizes[static_cast<std::size_t>(triangle[i])];
        out << "};\n";
    }
    out << "};\n";
    return out.take();
}

std::uint8_t byte_of(float part) { return static_cast<std::uint8_t>(std::lround(std::clamp(part, 0.0f, 1.0f) * 255)); }

}  // namespace

void write_size_view(const std::string& path, const TriangleSoup& soup, std::span<const double> sizes) {
    const std::string extension = io::extension_of(path);
    if (extension != ".pos" && extension != ".msh")
        throw IoError(path, 0, "views of sizes are written as .pos or .msh, not " + io::quoted(extension));
    io::check_writable("write_size_view", soup);
    const std::vector<double> finite = finite_sizes(sizes, soup.points.size());
    write_file(path,
               extension == ".pos" ? pos_text(soup, finite) : io::msh_text(soup) + io::msh_node_data("size", finite));
}

void write_coloured_ply(const std::string& path, std::span<const Eigen::Vector3d> points,
                        std::span<const Triangle> triangles, std::span<const double> values,
                        const ColouredPlyOptions& options) {
    if (io::extension_of(path) != ".ply") throw IoError(path, 0, "coloured meshes are written as .ply");
    io::check_writable("write_coloured_ply", {{points.begin(), points.end()}, {triangles.begin(), triangles.end()}});
    if (values.size() != points.size())
        throw std::invalid_argument("write_coloured_ply: " + std::to_string(values.size()) + " values for " +
                                    std::to_string(points.size()) + " points");
    if (options.name.empty() ||
        !std::all_of(options.name.begin(), options.name.end(), [](char c) { return c > ' ' && c <= '~'; }))
        throw std::invalid_argument("write_coloured_ply: the name '" + options.name + "' is not a word");

    io::TextWriter head(256);
    head << "ply\nformat binary_little_endian 1.0\nelement vertex " << points.size()
         << "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar "
            "green\nproperty uchar blue\n"
            "property double "
         << options.name << "\nelement face " << triangles.size()
         << "\nproperty list uchar int vertex_indices\nend_header\n";
    std::string bytes = head.take();
    bytes.reserve(bytes.size() + 35 * points.size() + 13 * triangles.size());
    const Range range = options.range.value_or(range_of(values, options.scale));
    for (std::size_t v = 0; v < points.size(); ++v) {
        for (int i = 0; i < 3; ++i) io::append_bytes(bytes, points[v][i]);
        const Colour colour = colour_at(options.map, place_on(range, options.scale, values[v]));
        for (const float part : {colour.r, colour.g, colour.b}) io::append_bytes(bytes, byte_of(part));
        io::append_bytes(bytes, values[v]);
    }
    for (const Triangle& triangle : triangles) {
        io::append_bytes(bytes, std::uint8_t{3});
        for (const int vertex : triangle) io::append_bytes(bytes, std::int32_t{vertex});
    }
    write_file(path, bytes);
}

}  // namespace gradus
