#include "fem/interactive/online_body.h"

#include "fem/model/floating_components.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>

namespace retractor::fem {

namespace {

    std::string at_vertex(const std::string& where, VertexId v) { return where + ", vertex " + std::to_string(v); }

    void check_vertex(const OnlineBody& body, VertexId v, const std::string& where)
    {
        if (!body.lives(v))
            throw InputError("there is no such vertex", at_vertex(where, v));
    }

    bool is_held(const OnlineBody& body, VertexId v)
    {
        return std::any_of(body.hooks.begin(), body.hooks.end(), [&](const auto& h) { return h.second.holds(v); });
    }

    bool is_supported(const OnlineBody& body, VertexId v) { return body.is_fixed(v) || body.K.bed(v) > 0.0; }

    VertexId slots(const OnlineBody& body) { return static_cast<VertexId>(body.K.slot_count()); }

    /// A mesh of the living vertices and elements. @param place per vertex id: number in the mesh, or -1
    mesh::TetMesh compact(const OnlineStiffness& K, std::vector<VertexId>& place)
    {
        mesh::TetMesh mesh;
        place.assign(K.slot_count(), -1);
        std::vector<Vec3> points;
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            if (K.alive(v)) {
                place[static_cast<std::size_t>(v)] = static_cast<VertexId>(points.size());
                points.push_back(K.position(v));
            }
        mesh.vertices.resize(static_cast<Eigen::Index>(points.size()), 3);
        for (std::size_t i = 0; i < points.size(); ++i)
            mesh.vertices.row(static_cast<Eigen::Index>(i)) = points[i].transpose();
        for (VertexId v = 0; v < static_cast<VertexId>(K.slot_count()); ++v)
            for (const TetId t : K.elements_round(v))
                if (K.tet(t)[0] == v)
                    for (const VertexId node : K.tet(t))
                        mesh.nodes.push_back(place[static_cast<std::size_t>(node)]);
        mesh.labels.assign(mesh.nodes.size() / 4, 1);
        return mesh;
    }

} // namespace

bool AttachedHook::holds(VertexId v) const
{
    return std::find(nodes.begin(), nodes.end(), v) != nodes.end() && !lost.contains(v);
}

void set_supports(OnlineBody& body, const Supports& supports)
{
    body.fixed.assign(body.K.slot_count(), 0);
    for (const VertexId v : supports.fixed) {
        check_vertex(body, v, "supports");
        body.fixed[static_cast<std::size_t>(v)] = 1;
    }
    if (!supports.hinges.empty())
        body.K.set_hinges(supports.hinges);
    if (supports.bedded.empty())
        return;
    std::vector<double> bed(body.K.slot_count(), 0.0);
    for (const BeddedVertex& bedded : supports.bedded) {
        check_vertex(body, bedded.vertex, "supports");
        bed[static_cast<std::size_t>(bedded.vertex)] = bedded.stiffness;
    }
    body.K.set_bed(std::move(bed));
}

void check_hook(const OnlineBody& body, const OnlineHook& hook)
{
    const std::string where = "hook '" + hook.name + "'";
    check_drive(hook.drive, hook.name);
    std::set<VertexId> nodes;
    for (const VertexId v : hook.nodes) {
        check_vertex(body, v, where);
        if (body.is_fixed(v))
            throw InputError("a hook holds a vertex that is fixed", at_vertex(where, v));
        if (is_held(body, v))
            throw InputError("two hooks hold one vertex", at_vertex(where, v));
        if (!nodes.insert(v).second)
            throw InputError("a hook names a vertex twice", at_vertex(where, v));
    }
    if (nodes.size() < kHookPatch)
        throw InputError("a hook is a patch of three vertices at least, never a point", where);
}

void carry_supports(OnlineBody& body, const mesh::MeshDelta& delta)
{
    body.fixed.resize(body.K.slot_count(), 0);
    for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born) {
        const bool fixed = born.origin == mesh::MeshDelta::Origin::restored
            ? body.ablated_fixed.give_back(born.id).value_or(0) != 0
            : body.is_fixed(born.a) && body.is_fixed(born.b);
        body.fixed[static_cast<std::size_t>(born.id)] = fixed ? 1 : 0;
    }
    for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone) {
        std::uint8_t& fixed = body.fixed[static_cast<std::size_t>(gone.id)];
        if (gone.origin == mesh::MeshDelta::Origin::restored)
            body.ablated_fixed.keep(gone.id, fixed);
        fixed = 0;
    }
}

bool carry_hooks(OnlineBody& body, const mesh::MeshDelta& delta)
{
    bool changed = false;
    for (auto& [id, hook] : body.hooks) {
        for (const mesh::MeshDelta::VertexBorn& born : delta.vertices_born)
            if (const auto lost = hook.lost.find(born.id); lost != hook.lost.end() && lost->second == born.position) {
                hook.lost.erase(lost);
                changed = true;
            }
        for (const mesh::MeshDelta::VertexBorn& gone : delta.vertices_gone)
            if (hook.holds(gone.id)) {
                hook.lost.emplace(gone.id, gone.position);
                changed = true;
            }
    }
    return changed;
}

std::vector<std::uint8_t> active_vertices(const OnlineBody& body)
{
    std::vector<std::uint8_t> active(body.K.slot_count(), 0);
    for (VertexId v = 0; v < slots(body); ++v)
        active[static_cast<std::size_t>(v)] = body.is_active(v) ? 1 : 0;
    return active;
}

std::set<VertexId> hooked_vertices(const OnlineBody& body)
{
    std::set<VertexId> vertices;
    for (const auto& [id, hook] : body.hooks)
        for (const VertexId v : hook.nodes)
            if (!hook.lost.contains(v))
                vertices.insert(v);
    return vertices;
}

std::set<VertexId> held_vertices(const OnlineBody& body)
{
    std::set<VertexId> vertices;
    for (const HeldVertex& h : body.held)
        vertices.insert(h.vertex);
    return vertices;
}

std::optional<HookId> gather_held(OnlineBody& body)
{
    body.held.clear();
    std::int32_t number = 0;
    for (const auto& [id, hook] : body.hooks) {
        std::size_t living = 0;
        for (const VertexId v : hook.nodes)
            if (body.is_active(v) && !hook.lost.contains(v)) {
                body.held.push_back({ v, number });
                ++living;
            }
        if (living < kHookPatch)
            return id;
        ++number;
    }
    return std::nullopt;
}

std::string partly_lost(const OnlineBody& body)
{
    std::string text;
    for (const auto& [id, hook] : body.hooks)
        if (!hook.lost.empty())
            text += (text.empty() ? "hook '" : "; hook '") + hook.name + "' holds "
                + std::to_string(hook.nodes.size() - hook.lost.size()) + " of its " + std::to_string(hook.nodes.size())
                + " vertices: the others are gone";
    return text;
}

/// Uses only the elements with a face in a patch, which determine the planes of the patches.
std::vector<FacingHooks> facing_hooks_of(const OnlineBody& body)
{
    mesh::TetMesh mesh;
    std::vector<HookPatch> patches;
    std::map<VertexId, VertexId> compact;
    std::set<TetId> faced;
    for (const auto& [id, hook] : body.hooks) {
        HookPatch& patch = patches.emplace_back(HookPatch { hook.name, hook.side, {} });
        std::map<TetId, int> corners;
        for (const VertexId v : hook.nodes) {
            if (hook.lost.contains(v) || !body.is_active(v))
                continue;
            patch.nodes.push_back(compact.emplace(v, static_cast<VertexId>(compact.size())).first->second);
            for (const TetId t : body.K.elements_round(v))
                if (++corners[t] == 3)
                    faced.insert(t);
        }
    }
    for (const TetId t : faced) {
        for (const VertexId v : body.K.tet(t))
            mesh.nodes.push_back(compact.emplace(v, static_cast<VertexId>(compact.size())).first->second);
        mesh.labels.push_back(body.K.label(t));
    }
    mesh.vertices.resize(static_cast<Eigen::Index>(compact.size()), 3);
    for (const auto& [id, v] : compact)
        mesh.vertices.row(v) = body.K.position(id).transpose();
    return facing_hooks(mesh, patches);
}

bool all_joined_to_something(const OnlineBody& body)
{
    std::vector<std::uint8_t> reached(body.K.slot_count(), 0);
    std::vector<VertexId> front;
    std::size_t count = 0;
    const auto reach = [&](VertexId v) {
        if (reached[static_cast<std::size_t>(v)] == 0) {
            reached[static_cast<std::size_t>(v)] = 1;
            front.push_back(v);
            ++count;
        }
    };
    for (VertexId v = 0; v < slots(body); ++v)
        if (body.K.alive(v) && is_supported(body, v))
            reach(v);
    for (const HeldVertex& h : body.held)
        reach(h.vertex);
    while (!front.empty()) {
        const VertexId v = front.back();
        front.pop_back();
        for (const VertexId next : body.K.row(v).column)
            reach(next);
    }
    return count == body.K.vertex_count();
}

std::string loose_piece(const OnlineBody& body)
{
    std::vector<VertexId> place, anchors;
    const mesh::TetMesh mesh = compact(body.K, place);
    for (VertexId v = 0; v < slots(body); ++v)
        if (body.K.alive(v) && is_supported(body, v))
            anchors.push_back(place[static_cast<std::size_t>(v)]);
    for (const HeldVertex& h : body.held)
        anchors.push_back(place[static_cast<std::size_t>(h.vertex)]);
    try {
        check_no_floating_component(mesh, anchors);
    } catch (const SolverError& error) {
        return std::string(error.what()) + ": " + error.where();
    }
    return {};
}

Eigen::VectorXd on_free(const OnlineBody& body, Eigen::VectorXd by_id)
{
    RETRACTOR_ASSERT(by_id.size() == 3 * static_cast<Eigen::Index>(body.K.slot_count()));
    for (std::size_t v = 0; v < body.fixed.size(); ++v)
        if (body.fixed[v] != 0)
            by_id.segment<3>(3 * static_cast<Eigen::Index>(v)).setZero();
    for (const HeldVertex& h : body.held)
        by_id.segment<3>(3 * h.vertex).setZero();
    return by_id;
}

Eigen::VectorXd right_side(const OnlineBody& body, const Eigen::VectorXd& hook_displacement)
{
    RETRACTOR_ASSERT(hook_displacement.size() == 3 * static_cast<Eigen::Index>(body.hooks.size()));
    Eigen::VectorXd b
        = body.K.loaded() ? body.K.load() : Eigen::VectorXd::Zero(3 * static_cast<Eigen::Index>(body.K.slot_count()));
    for (const HeldVertex& h : body.held)
        for_blocks(body.K, h.vertex, [&](VertexId v, const auto& block) {
            b.segment<3>(3 * v) -= block.transpose() * hook_displacement.segment<3>(3 * h.hook);
        });
    return on_free(body, std::move(b));
}

Eigen::VectorXd imbalance(const OnlineBody& body, const Eigen::VectorXd& displacement)
{
    Eigen::VectorXd r = -body.K.multiply(displacement);
    if (body.K.loaded())
        r += body.K.load();
    return r;
}

std::vector<Vec3> hook_forces(const OnlineBody& body, const Eigen::VectorXd& imbalance_of_all)
{
    RETRACTOR_ASSERT(imbalance_of_all.size() == 3 * static_cast<Eigen::Index>(body.K.slot_count()));
    std::vector<Vec3> forces(body.hooks.size(), Vec3::Zero());
    for (const HeldVertex& h : body.held)
        forces[static_cast<std::size_t>(h.hook)] -= imbalance_of_all.segment<3>(3 * h.vertex);
    return forces;
}

} // namespace retractor::fem
