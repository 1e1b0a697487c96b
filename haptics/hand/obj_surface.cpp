#include "haptics/hand/obj_surface.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace retractor::haptics {

namespace {

    /// Index of a position, from 0, of a word such as "7", "7/1", "7//3" or "-2".
    VertexId position_index(const std::string& word, std::size_t count, const std::string& where)
    {
        char* end = nullptr;
        const long number = std::strtol(word.c_str(), &end, 10);
        if (end == word.c_str() || (*end != '\0' && *end != '/'))
            throw InputError("a face has a corner that is no number: " + word, where);
        const long index = number > 0 ? number - 1 : static_cast<long>(count) + number;
        if (number == 0 || index < 0 || index >= static_cast<long>(count))
            throw InputError("a face has a corner that does not exist: " + word, where);
        return static_cast<VertexId>(index);
    }

} // namespace

TriMesh read_obj_surface(
    const std::filesystem::path& path, double unit_mm, std::map<std::string, std::vector<VertexId>>* groups)
{
    if (!(unit_mm > 0.0) || !std::isfinite(unit_mm))
        throw InputError("the unit of a surface must be positive, got " + std::to_string(unit_mm), path.string());
    std::ifstream file(path);
    if (!file)
        throw IoError("cannot be read", path.string());
    std::vector<std::array<double, 3>> places;
    std::map<std::array<double, 3>, VertexId> number_of;
    std::vector<VertexId> joined; // our vertex for each vertex of the file
    TriMesh mesh;
    std::map<std::string, std::set<VertexId>> members;
    std::string line, group;
    for (std::size_t n = 1; std::getline(file, line); ++n) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        const auto where = [&] { return path.string() + ":" + std::to_string(n); };
        if (kind == "v") {
            std::array<double, 3> p {};
            for (double& x : p)
                if (!(words >> x) || !std::isfinite(x))
                    throw InputError("a vertex needs three finite numbers", where());
            for (double& x : p)
                x *= unit_mm;
            const auto [at, added] = number_of.try_emplace(p, static_cast<VertexId>(places.size()));
            if (added)
                places.push_back(p);
            joined.push_back(at->second);
        } else if (kind == "g" || kind == "o") {
            group.clear();
            words >> group;
        } else if (kind == "f") {
            std::vector<VertexId> corners;
            std::string word;
            while (words >> word)
                corners.push_back(joined[static_cast<std::size_t>(position_index(word, joined.size(), where()))]);
            if (!group.empty())
                members[group].insert(corners.begin(), corners.end());
            if (corners.size() < 3)
                throw InputError("a face needs three corners", where());
            for (std::size_t i = 2; i < corners.size(); ++i)
                if (corners[0] != corners[i - 1] && corners[i - 1] != corners[i] && corners[i] != corners[0])
                    mesh.triangles.push_back({ corners[0], corners[i - 1], corners[i] });
        }
    }
    if (mesh.triangles.empty())
        throw InputError("the file has no faces", path.string());
    std::vector<VertexId> kept(places.size(), -1);
    std::vector<std::array<double, 3>> used;
    for (auto& triangle : mesh.triangles)
        for (VertexId& v : triangle) {
            VertexId& number = kept[static_cast<std::size_t>(v)];
            if (number < 0) {
                number = static_cast<VertexId>(used.size());
                used.push_back(places[static_cast<std::size_t>(v)]);
            }
            v = number;
        }
    mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
    for (std::size_t v = 0; v < used.size(); ++v)
        mesh.vertices.row(static_cast<Eigen::Index>(v)) << used[v][0], used[v][1], used[v][2];
    if (groups != nullptr) {
        groups->clear();
        for (const auto& [name, vertices] : members)
            for (const VertexId v : vertices)
                if (const VertexId number = kept[static_cast<std::size_t>(v)]; number >= 0)
                    (*groups)[name].push_back(number);
        for (auto& [name, vertices] : *groups)
            std::sort(vertices.begin(), vertices.end());
    }
    return mesh;
}

} // namespace retractor::haptics
