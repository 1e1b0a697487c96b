#include "haptics/spheres/surface_locator.h"
#include "haptics/springs/spring_motion.h"
#include "haptics/springs/spring_tissue.h"
#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "mesh/base/triangle.h"
#include "planner/session/tissue_choice.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <utility>
#include <vector>

namespace retractor::planner {

namespace {

    constexpr double kDensity = 1.06e-9; // tonne/mm^3
    constexpr double kStep = 2.5e-4; // s; a tick has at most four steps
    constexpr double kDrag = 60.0; // 1/s; near the critical drag of an organ's slowest motion
    constexpr std::size_t kMostSprings = 400'000;

    /// The longest edge of the surface near a site: within two fingertips, or of the triangle that contains the site.
    double coarsest_near(const datasets::PalpationScene& scene, double radius)
    {
        const mesh::TetMesh& mesh = scene.body.mesh;
        double longest = 0.0;
        std::vector<double> nearest(scene.sites.size(), std::numeric_limits<double>::infinity()), under(nearest.size());
        for (const mesh::TetFace& face : mesh::boundary_faces(mesh)) {
            const std::array<Vec3, 3> at = triangle_corners(mesh.vertices, mesh::face_vertices(mesh, face));
            double edge = 0.0;
            for (std::size_t i = 0; i < 3; ++i) {
                const Vec3 &a = at[i], &b = at[(i + 1) % 3];
                edge = std::max(edge, (a - b).norm());
                for (const datasets::TouchSite& site : scene.sites)
                    if ((0.5 * (a + b) - site.point).norm() < 2.0 * radius)
                        longest = std::max(longest, (a - b).norm());
            }
            for (std::size_t s = 0; s < nearest.size(); ++s) {
                const double distance
                    = haptics::nearest_on_triangle(scene.sites[s].point, at[0], at[1], at[2]).distance;
                if (distance < nearest[s]) {
                    nearest[s] = distance;
                    under[s] = edge;
                }
            }
        }
        return under.empty() ? longest : std::max(longest, *std::max_element(under.begin(), under.end()));
    }

    /// Divides every element into eight: four corners, and the middle octahedron along the diagonal between the
    /// midpoints of edges 0 and 5.
    datasets::ElasticModel split_in_eight(const datasets::ElasticModel& coarse)
    {
        constexpr std::array<std::array<int, 4>, 8> kParts { { { 0, 4, 6, 7 }, { 4, 1, 5, 8 }, { 6, 5, 2, 9 },
            { 7, 8, 9, 3 }, { 4, 9, 6, 7 }, { 4, 9, 7, 8 }, { 4, 9, 8, 5 }, { 4, 9, 5, 6 } } };
        const mesh::TetMesh quadratic = mesh::with_midpoints(coarse.mesh);
        datasets::ElasticModel fine;
        fine.mesh.vertices = quadratic.vertices;
        fine.roles = coarse.roles;
        fine.roles.resize(quadratic.vertex_count(), datasets::VertexRole::free);
        for (std::size_t t = 0; t < quadratic.tet_count(); ++t) {
            const auto nodes = quadratic.tet(static_cast<TetId>(t));
            for (const auto& part : kParts) {
                for (const int corner : part)
                    fine.mesh.nodes.push_back(nodes[static_cast<std::size_t>(corner)]);
                fine.mesh.labels.push_back(quadratic.labels[t]);
                fine.youngs_modulus.push_back(coarse.youngs_modulus[t]);
                fine.poissons_ratio.push_back(coarse.poissons_ratio[t]);
            }
            // A midpoint has the role that both its corners have.
            for (std::size_t e = 0; e < mesh::kTetEdges.size(); ++e) {
                const auto role = [&](int corner) {
                    return coarse.roles[static_cast<std::size_t>(nodes[static_cast<std::size_t>(corner)])];
                };
                if (role(mesh::kTetEdges[e][0]) == role(mesh::kTetEdges[e][1]))
                    fine.roles[static_cast<std::size_t>(nodes[4 + e])] = role(mesh::kTetEdges[e][0]);
            }
        }
        return fine;
    }

    /// @return the number of splits
    int refine_for_fingertips(datasets::PalpationScene& scene, double radius)
    {
        const double wanted = 2.0 * radius; // no fingertip passes between two particles at this distance
        constexpr std::size_t kEdgesOfTet = 8; // about: elements share edges, and a split makes eight elements
        int splits = 0;
        for (; coarsest_near(scene, radius) > wanted; ++splits) {
            if (scene.body.mesh.tet_count() * kEdgesOfTet > kMostSprings) {
                throw InputError(
                    formatted(
                        "a fingertip of %.3g mm would fall between particles up to %.3g mm apart, and finer ones would "
                        "need too many springs; take a larger fingertip, a finer scene, or the model fem",
                        radius, coarsest_near(scene, radius)),
                    formatted("%s, model springs", scene.name.c_str()), { "radius_mm", "model" });
            }
            scene.body = split_in_eight(scene.body);
        }
        return splits;
    }

    haptics::SpringPulse pulse_on(const datasets::PalpationScene& scene, const haptics::PulsePressure& pressure)
    {
        haptics::SpringPulse pulse { pressure, scene.rest_mmHg * haptics::kMPaPerMmHg, {}, {} };
        const mesh::TetMesh& mesh = scene.body.mesh;
        std::vector<std::uint8_t> inner(mesh.vertex_count()), fixed(mesh.vertex_count());
        for (std::size_t v = 0; v < inner.size(); ++v) {
            inner[v] = scene.body.roles[v] == datasets::VertexRole::inner_wall;
            fixed[v] = scene.body.roles[v] == datasets::VertexRole::fixed;
        }
        std::map<VertexId, Vec3> areas;
        for (const mesh::TetFace& face : haptics::wall_faces(mesh, inner, fixed).inner) {
            const auto c = mesh::face_vertices(mesh, face);
            const Vec3 third = -area_vector(mesh.vertices, c) / 3.0; // opposite to the wall's outward normal
            for (const VertexId v : c)
                areas.try_emplace(v, Vec3::Zero()).first->second += third;
        }
        for (const auto& [v, area] : areas) {
            pulse.particles.push_back(v);
            pulse.areas.push_back(area);
        }
        return pulse;
    }

    struct Organ {
        haptics::SpringBody body;
        double heavier = 1.0;
    };

    Organ organ_of(const datasets::PalpationScene& scene, double calibration)
    {
        std::vector<VertexId> held;
        for (std::size_t v = 0; v < scene.body.roles.size(); ++v)
            if (scene.body.roles[v] == datasets::VertexRole::fixed)
                held.push_back(static_cast<VertexId>(v));
        Organ organ {
            haptics::make_spring_organ(scene.body.mesh, scene.body.youngs_modulus, kDensity, held, calibration), 1.0
        };
        organ.heavier = haptics::slow_down_to(organ.body, kStep);
        return organ;
    }

    /// Presses on the first site until the tissue is at rest. @return the force
    double force_at_first_site(
        haptics::TissueResponse& tissue, const datasets::TouchSite& site, double radius, double depth)
    {
        constexpr int kDown = 200, kTicks = 800, kMeasured = 100;
        constexpr double kTick = 1e-3; // s
        haptics::Fingertip finger;
        finger.radius = radius;
        haptics::FingerContact contact;
        double sum = 0.0;
        for (int i = 0; i < kTicks; ++i) {
            const double above = std::max(0.0, 1.0 - static_cast<double>(i) / kDown);
            finger.position = site.point + (radius - depth + above * (depth + 1.0)) * site.outward;
            tissue.tick(i * kTick, kTick, { &finger, 1 }, { &contact, 1 });
            if (i >= kTicks - kMeasured)
                sum += contact.force.dot(site.outward) / kMeasured;
        }
        return sum;
    }

    ChosenTissue sheet_tissue(const datasets::PalpationScene& scene, const TissueChoice& choice)
    {
        const haptics::DeviceVoigt voigt = haptics::device_voigt({});
        haptics::SheetOptions options;
        options.columns = options.rows = scene.sheet_particles;
        options.stiffness = voigt.stiffness * (choice.calibration > 0.0 ? choice.calibration : 1.0);
        haptics::SpringBody sheet = haptics::make_spring_sheet(options);
        ChosenTissue chosen;
        chosen.notes.push_back(
            "a sheet of " + std::to_string(sheet.springs.size()) + " springs, K and D as shares of the device's range");
        chosen.response = std::make_unique<haptics::SpringTissue>(std::move(sheet),
            haptics::ElementLaw { .voigt_time = voigt.voigt_time },
            haptics::SpringTissueOptions { .fingers = choice.fingers });
        return chosen;
    }

    double calibrate(const datasets::PalpationScene& coarse, const datasets::PalpationScene& fine, double radius,
        double wanted_depth, const Job& job)
    {
        if (coarse.sites.empty())
            return 1.0;
        const double depth = std::min(wanted_depth, 0.75 * radius);
        haptics::CondensedOptions options;
        options.fingertip = haptics::FingertipShape::sphere;
        options.fetch_all_below = 0;
        options.rest_pressure = coarse.rest_mmHg * haptics::kMPaPerMmHg;
        haptics::CondensedTissue elements(
            coarse.body, haptics::PulsePressure::constant(coarse.rest_mmHg), options, job);
        haptics::Fingertip there;
        there.radius = radius;
        there.position = coarse.sites[0].point + (radius - depth) * coarse.sites[0].outward;
        elements.prepare({ &there, 1 });
        haptics::SpringTissue springs(organ_of(fine, 1.0).body, haptics::ElementLaw { .drag = kDrag });
        const double expected = force_at_first_site(elements, coarse.sites[0], radius, depth),
                     got = force_at_first_site(springs, coarse.sites[0], radius, depth);
        if (!(expected > 0.0) || !(got > 0.0))
            throw SolverError("springs and elements could not be compared: the fingertip does not meet the body at \""
                    + coarse.sites[0].name + '"',
                coarse.name);
        return expected / got;
    }

} // namespace

double measured_calibration(const datasets::PalpationScene& scene, double radius_mm, double depth_mm, const Job& job)
{
    datasets::PalpationScene fine = scene;
    refine_for_fingertips(fine, radius_mm);
    return calibrate(scene, fine, radius_mm, depth_mm, job);
}

ChosenTissue make_springs(const datasets::PalpationScene& scene, const TissueChoice& choice, const Job& job)
{
    if (scene.sheet_particles > 0)
        return sheet_tissue(scene, choice);
    datasets::PalpationScene fine = scene;
    const int splits = refine_for_fingertips(fine, choice.radius_mm);
    const bool measured = choice.calibration <= 0.0;
    const double calibration
        = measured ? calibrate(scene, fine, choice.radius_mm, choice.depth_mm, job) : choice.calibration;
    Organ organ = organ_of(fine, calibration);
    ChosenTissue chosen;
    chosen.notes.push_back(formatted(
        "%zu particles, %zu springs (every element split in eight %d times), stiffness %.3f times the edges' law%s, "
        "%.3g times as heavy as tissue",
        organ.body.mass.size(), organ.body.springs.size(), splits, calibration,
        measured ? ", measured against ten-node elements" : "", organ.heavier));
    haptics::SpringTissueOptions options { .fingers = choice.fingers };
    if (datasets::has_inner_wall(scene.body))
        options.pulse = pulse_on(fine, pulse_of(scene, choice));
    const auto [softest, stiffest]
        = std::minmax_element(scene.body.youngs_modulus.begin(), scene.body.youngs_modulus.end());
    if (datasets::has_inner_wall(scene.body)
        && *softest < *stiffest) // the aorta phantom gives 0.34 N against 0.30 N; elements give 0.14 N and 0.22 N
        chosen.notes.push_back("springs do not tell stiffer regions by their pulse: theirs comes out larger than the "
                               "normal wall's, with elements smaller (use the model fem to compare pulses)");
    options.tells_stiffness = organ.heavier <= 1.0;
    chosen.response = std::make_unique<haptics::SpringTissue>(
        std::move(organ.body), haptics::ElementLaw { .drag = kDrag }, options);
    return chosen;
}

} // namespace retractor::planner
