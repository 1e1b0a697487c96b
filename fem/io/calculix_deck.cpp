#include "fem/io/calculix_deck.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <map>
#include <optional>
#include <utility>

namespace retractor::fem {

namespace {

    /// The number as text. ccx reads numbers of at most 20 characters, so the text is the shortest one that
    /// reproduces the double, or has 13 digits.
    std::string number(double value)
    {
        constexpr std::size_t kWidest = 20;
        constexpr int kDigits = 12;
        std::array<char, 64> text {};
        const auto exact = std::to_chars(text.data(), text.data() + text.size(), value);
        if (static_cast<std::size_t>(exact.ptr - text.data()) <= kWidest)
            return { text.data(), exact.ptr };
        const auto cut
            = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::scientific, kDigits);
        return { text.data(), cut.ptr };
    }

    /// The text without line breaks, because a comment must stay on one line.
    std::string one_line(std::string text)
    {
        for (char& c : text)
            if (static_cast<unsigned char>(c) < ' ')
                c = ' ';
        return text;
    }

    std::string node_number(VertexId v) { return std::to_string(static_cast<long>(v) + 1); }

    void write_nodes(std::string& deck, const mesh::TetMesh& mesh)
    {
        deck += "*NODE, NSET=NALL\n";
        for (Eigen::Index v = 0; v < mesh.vertices.rows(); ++v) {
            deck += node_number(static_cast<VertexId>(v));
            for (Eigen::Index axis = 0; axis < 3; ++axis)
                deck += "," + number(mesh.vertices(v, axis));
            deck += "\n";
        }
    }

    std::string tissue(Label label) { return "TISSUE" + std::to_string(label); }

    void write_elements(std::string& deck, const mesh::TetMesh& mesh, Label label)
    {
        deck += "*ELEMENT, TYPE=" + std::string(mesh.nodes_per_tet == 10 ? "C3D10" : "C3D4")
            + ", ELSET=" + tissue(label) + "\n";
        for (std::size_t t = 0; t < mesh.tet_count(); ++t) {
            if (mesh.labels[t] != label)
                continue;
            deck += std::to_string(t + 1);
            for (const VertexId v : mesh.tet(static_cast<TetId>(t)))
                deck += "," + node_number(v);
            deck += "\n";
        }
    }

    void write_material(std::string& deck, Label label, const Material& material)
    {
        deck += "** label " + std::to_string(label) + ": " + one_line(material.name)
            + "\n*MATERIAL, NAME=" + tissue(label) + "\n*ELASTIC\n" + number(material.youngs_modulus_MPa) + ","
            + number(material.poissons_ratio) + "\n*SOLID SECTION, ELSET=" + tissue(label)
            + ", MATERIAL=" + tissue(label) + "\n";
    }

    /// Springs to the ground. All springs of a set have one stiffness, so there is one set per stiffness and axis.
    void write_beds(std::string& deck, const ElasticProblem& problem)
    {
        std::map<double, std::vector<VertexId>> nodes_of_stiffness;
        for (const BeddedVertex& bedded : problem.supports.bedded)
            nodes_of_stiffness[bedded.stiffness].push_back(bedded.vertex);
        std::size_t element = problem.mesh.tet_count();
        int set = 0;
        for (const auto& [stiffness, nodes] : nodes_of_stiffness)
            for (int axis = 1; axis <= 3; ++axis) {
                const std::string name = "BED" + std::to_string(++set);
                deck += "*ELEMENT, TYPE=SPRING1, ELSET=" + name + "\n";
                for (const VertexId v : nodes)
                    deck += std::to_string(++element) + "," + node_number(v) + "\n";
                deck += "*SPRING, ELSET=" + name + "\n" + std::to_string(axis) + "\n" + number(stiffness) + "\n";
            }
    }

    /// Hinges at rest. The extra node of an edge, after the nodes of the mesh, has x = spring . (u_b - u_a).
    void write_hinges(std::string& deck, const ElasticProblem& problem)
    {
        if (problem.supports.hinges.empty())
            return;
        const mesh::TetMesh& mesh = problem.mesh;
        std::string nodes = "*NODE, NSET=HINGES\n", equations = "*EQUATION\n",
                    elements = "*ELEMENT, TYPE=SPRING1, ELSET=HINGE\n";
        auto extra = static_cast<VertexId>(mesh.vertex_count());
        std::size_t element = mesh.tet_count() + 3 * problem.supports.bedded.size();
        for (const Hinge& hinge : problem.supports.hinges)
            for (const HingeEdge& edge : hinge.edges) {
                const Vec3 from = point_at(mesh.vertices, edge.a), to = point_at(mesh.vertices, edge.b);
                const Vec3 spring = hinge_spring(hinge, edge, to - from);
                std::vector<std::string> terms { node_number(extra) + ",1,-1." };
                for (const auto& [v, sign] : { std::pair(edge.a, -1.0), std::pair(edge.b, 1.0) })
                    for (Eigen::Index axis = 0; axis < 3; ++axis)
                        if (spring[axis] != 0.0)
                            terms.push_back(
                                node_number(v) + "," + std::to_string(axis + 1) + "," + number(sign * spring[axis]));
                constexpr std::size_t kTermsPerLine = 4;
                equations += std::to_string(terms.size()) + "\n";
                for (std::size_t i = 0; i < terms.size(); ++i)
                    equations += terms[i] + ((i + 1) % kTermsPerLine == 0 || i + 1 == terms.size() ? "\n" : ",");
                nodes += node_number(extra);
                for (Eigen::Index axis = 0; axis < 3; ++axis)
                    nodes += "," + number(0.5 * (from + to)[axis]);
                nodes += "\n";
                elements += std::to_string(++element) + "," + node_number(extra++) + "\n";
            }
        deck += nodes + equations + elements + "*SPRING, ELSET=HINGE\n1\n1.\n*BOUNDARY\nHINGES,2,3\n";
    }

    void write_node_set(std::string& deck, const std::string& name, const std::vector<VertexId>& nodes)
    {
        deck += "*NSET, NSET=" + name + "\n";
        for (const VertexId v : nodes)
            deck += node_number(v) + ",\n";
    }

    std::string hook_set(std::size_t hook) { return "HOOK" + std::to_string(hook + 1); }

    /// Nodal forces, node by node.
    void write_loads(std::string& deck, const Eigen::VectorXd& loads)
    {
        bool any = false;
        for (Eigen::Index i = 0; i < loads.size(); ++i) {
            if (loads[i] == 0.0)
                continue;
            deck += any ? "" : "*CLOAD\n";
            any = true;
            deck += node_number(static_cast<VertexId>(i / 3)) + "," + std::to_string(i % 3 + 1) + "," + number(loads[i])
                + "\n";
        }
    }

    void write_step(std::string& deck, const ElasticProblem& problem, bool held)
    {
        deck += "*STEP\n*STATIC\n";
        if (!problem.supports.fixed.empty())
            deck += "*BOUNDARY\nFIXED,1,3\n";
        for (std::size_t h = 0; h < problem.hooks.size(); ++h) {
            const HookPatch& hook = problem.hooks[h];
            deck += "*BOUNDARY\n";
            const auto prescribe = [&](const std::string& nodes, const Vec3& moved) {
                for (Eigen::Index axis = 0; axis < 3; ++axis) {
                    const std::string dof = std::to_string(axis + 1);
                    deck += nodes + "," + dof + "," + dof + "," + number(moved[axis]) + "\n";
                }
            };
            if (!hook.turns())
                prescribe(hook_set(h), hook.displacement);
            else // each node has a displacement of its own
                for (const VertexId v : hook.nodes)
                    prescribe(node_number(v), hook.displacement_of(problem.mesh.vertices.row(v).transpose()));
        }
        write_loads(deck, nodal_loads(problem));
        deck += "*NODE PRINT, NSET=NALL\nU\n";
        if (held)
            deck += "*NODE PRINT, NSET=HELD\nRF\n";
        deck += "*END STEP\n";
    }

    /// The words of a line, separated by blanks.
    std::vector<std::string_view> words_of(std::string_view line)
    {
        std::vector<std::string_view> words;
        for (std::size_t begin = line.find_first_not_of(" \t\r"); begin != std::string_view::npos;) {
            const std::size_t end = std::min(line.find_first_of(" \t\r", begin), line.size());
            words.push_back(line.substr(begin, end - begin));
            begin = line.find_first_not_of(" \t\r", end);
        }
        return words;
    }

    template <class Number> std::optional<Number> parsed(std::string_view word)
    {
        Number value {};
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size())
            return std::nullopt;
        return value;
    }

    /// Reads a line "node x y z".
    std::optional<std::pair<long, Vec3>> node_line(const std::vector<std::string_view>& words)
    {
        if (words.size() != 4)
            return std::nullopt;
        const auto node = parsed<long>(words[0]);
        const auto x = parsed<double>(words[1]), y = parsed<double>(words[2]), z = parsed<double>(words[3]);
        if (!node || !x || !y || !z || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*z))
            return std::nullopt;
        return std::pair { *node, Vec3(*x, *y, *z) };
    }

    struct Section {
        Points* values = nullptr;
        std::vector<std::uint8_t>* met = nullptr;
    };

    void require(const std::vector<std::uint8_t>& met, VertexId v, const char* what)
    {
        if (met[static_cast<std::size_t>(v)] == 0)
            throw InputError(std::string("there is no ") + what + " for node " + node_number(v)
                    + ": ccx stopped early, or its file was cut off",
                "ccx's .dat file");
    }

    /// Subtracts the loads: for a held node ccx prints the force of its elements, which balances reaction and load
    /// together.
    void take_off_loads(const ElasticProblem& problem, std::vector<VertexId> held, Points& reaction)
    {
        const Eigen::VectorXd loads = nodal_loads(problem);
        if (loads.size() == 0)
            return;
        std::sort(held.begin(), held.end());
        held.erase(std::unique(held.begin(), held.end()), held.end());
        for (const VertexId v : held)
            reaction.row(v) -= loads.segment<3>(3 * static_cast<Eigen::Index>(v)).transpose();
    }

} // namespace

std::string calculix_deck(const ElasticProblem& problem)
{
    check_problem(problem);
    const mesh::TetMesh& mesh = problem.mesh;
    constexpr std::size_t kBytesPerNode = 64, kBytesPerElementNode = 8;
    std::string deck;
    deck.reserve(kBytesPerNode * mesh.vertex_count() + kBytesPerElementNode * (mesh.nodes.size() + mesh.tet_count()));
    deck += "*HEADING\nopened wound, linear; units mm, N, MPa; frame patient LPS\n";
    write_nodes(deck, mesh);
    for (const Label label : labels_met(mesh)) {
        write_elements(deck, mesh, label);
        write_material(deck, label, problem.material_of_label[label]);
    }
    write_beds(deck, problem);
    write_hinges(deck, problem);
    if (!problem.supports.fixed.empty())
        write_node_set(deck, "FIXED", problem.supports.fixed);
    for (std::size_t h = 0; h < problem.hooks.size(); ++h) {
        deck += "** hook '" + one_line(problem.hooks[h].name) + "'\n";
        write_node_set(deck, hook_set(h), problem.hooks[h].nodes);
    }
    const std::vector<VertexId> held = prescribe(mesh, problem.supports, problem.hooks).nodes;
    if (!held.empty())
        write_node_set(deck, "HELD", held);
    write_step(deck, problem, !held.empty());
    return deck;
}

CalculixAnswer read_calculix_answer(std::string_view dat, const ElasticProblem& problem)
{
    const Eigen::Index n = problem.mesh.vertices.rows();
    CalculixAnswer answer { Points::Zero(n, 3), Points::Zero(n, 3) };
    std::vector<std::uint8_t> moved(static_cast<std::size_t>(n), 0), reacted(static_cast<std::size_t>(n), 0);
    Section section;
    int line_number = 0;
    while (!dat.empty()) {
        const std::size_t end = std::min(dat.find('\n'), dat.size());
        const std::string_view line = dat.substr(0, end);
        dat.remove_prefix(std::min(end + 1, dat.size()));
        ++line_number;
        const std::vector<std::string_view> words = words_of(line);
        if (words.empty())
            continue;
        if (words[0] == "displacements" || words[0] == "forces") {
            section = words[0] == "forces" ? Section { &answer.reaction, &reacted }
                                           : Section { &answer.displacement, &moved };
            continue;
        }
        if (section.values == nullptr)
            continue;
        const auto entry = node_line(words);
        if (!entry || entry->first < 1 || entry->first > n)
            throw InputError("line " + std::to_string(line_number)
                    + " is not a node of the mesh and three numbers: " + std::string(line.substr(0, 80)),
                "ccx's .dat file");
        section.values->row(entry->first - 1) = entry->second.transpose();
        (*section.met)[static_cast<std::size_t>(entry->first - 1)] = 1;
    }
    for (const VertexId v : problem.mesh.nodes)
        require(moved, v, "displacement");
    const std::vector<VertexId> held = prescribe(problem.mesh, problem.supports, problem.hooks).nodes;
    for (const VertexId v : held)
        require(reacted, v, "reaction");
    take_off_loads(problem, held, answer.reaction);
    return answer;
}

} // namespace retractor::fem
