#include "tests/verification/reference/calculix_reference.h"

#include "fem/material/material.h"
#include "mesh/base/error.h"
#include "tests/verification/framework/number_list.h"

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace retractor::verification {

namespace {

    struct Deck {
        std::map<int, Vec3> nodes;
        std::vector<std::vector<int>> elements;
        std::map<std::string, std::vector<int>> sets;
        std::vector<std::string> boundary, loads;
        std::vector<double> elastic;
    };

    Deck read_deck(const std::filesystem::path& file)
    {
        Deck deck;
        std::ifstream stream(file);
        if (!stream)
            throw IoError("the file cannot be opened", file.string());
        std::string line, section;
        std::vector<int> element;
        while (std::getline(stream, line)) {
            if (line.starts_with("**"))
                continue;
            if (line.starts_with("*")) {
                section = line;
                continue;
            }
            const std::vector<double> values = number_list(line);
            if (section.starts_with("*NODE,"))
                deck.nodes[static_cast<int>(values[0])] = { values[1], values[2], values.size() > 3 ? values[3] : 0.0 };
            else if (section.starts_with("*ELEMENT")) {
                for (const double v : values)
                    element.push_back(static_cast<int>(v));
                if (element.size() == 11) { // element number and ten nodes, over two lines
                    deck.elements.emplace_back(element.begin() + 1, element.end());
                    element.clear();
                }
            } else if (section.starts_with("*NSET,NSET="))
                for (const double v : values)
                    deck.sets[section.substr(11)].push_back(static_cast<int>(v));
            else if (section.starts_with("*BOUNDARY"))
                deck.boundary.push_back(line);
            else if (section.starts_with("*CLOAD"))
                deck.loads.push_back(line);
            else if (section.starts_with("*ELASTIC"))
                deck.elastic = values;
        }
        return deck;
    }

    std::map<int, Vec3> read_displacements(const std::filesystem::path& file)
    {
        std::map<int, Vec3> all;
        std::ifstream stream(file);
        if (!stream)
            throw IoError("the file cannot be opened", file.string());
        std::string line;
        bool inside = false;
        while (std::getline(stream, line)) {
            if (line.find("displacements") != std::string::npos)
                inside = true;
            else if (line.find("forces") != std::string::npos)
                break;
            else if (const auto v = number_list(line); inside && v.size() == 4)
                all[static_cast<int>(v[0])] = { v[1], v[2], v[3] };
        }
        return all;
    }

    /// Reads "FIX,3,3" or "1,1,2": a node or a node set, then numbers.
    std::pair<std::vector<int>, std::vector<double>> nodes_and_numbers(const Deck& deck, const std::string& line)
    {
        const auto comma = line.find(',');
        const std::string name = line.substr(0, comma);
        const auto set = deck.sets.find(name);
        return { set != deck.sets.end() ? set->second : std::vector<int> { std::stoi(name) },
            number_list(line.substr(comma + 1)) };
    }

    VertexId vertex(const CalculixModel& model, int number, const std::filesystem::path& file)
    {
        const auto at = model.vertex_of_number.find(number);
        if (at == model.vertex_of_number.end())
            throw IoError("there is no node " + std::to_string(number), file.string());
        return at->second;
    }

} // namespace

CalculixModel read_calculix(const std::filesystem::path& file)
{
    const Deck deck = read_deck(file);
    if (deck.elements.empty() || deck.elastic.size() != 2)
        throw IoError("the deck needs ten-node elements and one elastic material", file.string());
    CalculixModel model;
    mesh::TetMesh& mesh = model.mesh;
    mesh.nodes_per_tet = 10;
    mesh.vertices.resize(static_cast<Eigen::Index>(deck.nodes.size()), 3);
    for (const auto& [number, p] : deck.nodes) {
        const auto v = static_cast<VertexId>(model.vertex_of_number.size());
        mesh.vertices.row(v) = p.transpose();
        model.vertex_of_number[number] = v;
    }
    // CalculiX orders the midpoints 12, 23, 13, 14, 24, 34, as TetMesh does.
    for (const auto& element : deck.elements) {
        for (const int number : element)
            mesh.nodes.push_back(vertex(model, number, file));
        mesh.labels.push_back(1);
    }
    mesh::check_mesh(mesh);
    model.held = hold_nothing(mesh);
    for (const std::string& line : deck.boundary) {
        const auto [nodes, values] = nodes_and_numbers(deck, line);
        for (const int number : nodes)
            for (int axis = static_cast<int>(values.at(0)); axis <= static_cast<int>(values.at(1)); ++axis)
                hold(model.held, vertex(model, number, file), axis - 1);
    }
    model.loads = Eigen::VectorXd::Zero(3 * mesh.vertices.rows());
    for (const std::string& line : deck.loads) {
        const auto [nodes, values] = nodes_and_numbers(deck, line);
        for (const int number : nodes)
            model.loads[3 * vertex(model, number, file) + static_cast<int>(values.at(0)) - 1] += values.at(1);
    }
    model.lame = fem::lame({ "CalculiX", deck.elastic[0], deck.elastic[1], 1e-9, file.string() });
    return model;
}

std::vector<Vec3> read_calculix_displacements(const std::filesystem::path& file, const CalculixModel& model)
{
    const std::map<int, Vec3> printed = read_displacements(file);
    std::vector<Vec3> all(model.mesh.vertex_count(), Vec3::Zero());
    for (const auto& [number, v] : model.vertex_of_number) {
        const auto at = printed.find(number);
        if (at == printed.end())
            throw IoError("there is no displacement of node " + std::to_string(number), file.string());
        all[static_cast<std::size_t>(v)] = at->second;
    }
    return all;
}

} // namespace retractor::verification
