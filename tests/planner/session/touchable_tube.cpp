#include "tests/planner/session/touchable_tube.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/spheres/sphere_tissue.h"
#include "mesh/base/error.h"
#include "mesh/surface/wound_surface.h"
#include "mesh/tetrahedra/tet_mesh.h"
#include "tests/support/test_shapes.h"

#include <limits>

namespace retractor::planner {

namespace {

    class SickTissue : public haptics::TissueResponse {
    public:
        SickTissue(std::unique_ptr<haptics::TissueResponse> tissue, std::shared_ptr<TubeControl> control)
            : tissue_(std::move(tissue))
            , control_(std::move(control))
        {
        }
        std::string_view name() const noexcept override { return tissue_->name(); }
        std::size_t finger_count() const noexcept override { return tissue_->finger_count(); }
        void tick(double time_s, double step_s, std::span<const haptics::Fingertip> fingers,
            std::span<haptics::FingerContact> contacts) noexcept override
        {
            tissue_->tick(time_s, step_s, fingers, contacts);
            if (control_->sick)
                contacts[0].force.setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        const TriMesh& surface() const noexcept override { return tissue_->surface(); }
        void follow(Points& deformed) override { tissue_->follow(deformed); }

    private:
        std::unique_ptr<haptics::TissueResponse> tissue_;
        std::shared_ptr<TubeControl> control_;
    };

    std::unique_ptr<haptics::TissueResponse> elements(
        const datasets::PalpationScene& scene, const TissueChoice& wish, bool pulse, const Job& job)
    {
        haptics::CondensedOptions options;
        options.element = haptics::TouchElement::p1; // quick to make; how stiff it is matters to no test here
        options.fingers = wish.fingers;
        options.rest_pressure = scene.rest_mmHg * haptics::kMPaPerMmHg;
        return std::make_unique<haptics::CondensedTissue>(scene.body,
            pulse ? haptics::PulsePressure::aortic(scene.heart_rate_per_min)
                  : haptics::PulsePressure::constant(scene.rest_mmHg),
            options, job);
    }

    std::unique_ptr<haptics::TissueResponse> spheres(const datasets::PalpationScene& scene, const TissueChoice& wish)
    {
        TriMesh surface { scene.body.mesh.vertices, {}, {} };
        for (const mesh::TetFace& face : mesh::boundary_faces(scene.body.mesh))
            surface.triangles.push_back(mesh::face_vertices(scene.body.mesh, face));
        haptics::SphereLaw law;
        law.fingers = wish.fingers;
        const haptics::SphereFilling filling = haptics::fill_with_spheres(surface, 0.6);
        return std::make_unique<haptics::SphereTissue>(
            std::vector<haptics::SphereOrgan> { { scene.name, surface, filling, 0.02 } }, law);
    }

} // namespace

datasets::PalpationScene tube_scene()
{
    datasets::AortaParameters parameters;
    parameters.shape = datasets::AortaParameters::Shape::tube;
    parameters.length_mm = 60.0;
    parameters.region.length_mm = 0.0;
    parameters.around = 16;
    parameters.along = 16;
    return datasets::make_aorta_phantom(parameters);
}

Vec3 tube_axis()
{
    const Points p = tube_scene().body.mesh.vertices;
    Eigen::Index longest = 0;
    (p.colwise().maxCoeff() - p.colwise().minCoeff()).maxCoeff(&longest);
    return Vec3::Unit(longest);
}

std::vector<ThroughOpening> slit_before_tube(double width_mm)
{
    constexpr double kBefore = 40.0, kThick = 15.0, kFar = 120.0; // mm
    const datasets::TouchSite site = tube_scene().site("centre");
    Mat3 turn; // columns: across the slit, along it, out
    turn.col(2) = site.outward;
    turn.col(0) = (tube_axis() - tube_axis().dot(site.outward) * site.outward).normalized();
    turn.col(1) = turn.col(2).cross(turn.col(0));
    const Vec3 centre = site.point + kBefore * site.outward;
    std::vector<mesh::NamedSurface> lips {
        { "left lip", test_support::box_surface({ -kFar, -kFar, -kThick }, { -0.5 * width_mm, kFar, 0.0 }) },
        { "right lip", test_support::box_surface({ 0.5 * width_mm, -kFar, -kThick }, { kFar, kFar, 0.0 }) }
    };
    for (mesh::NamedSurface& lip : lips)
        lip.surface.vertices = (lip.surface.vertices * turn.transpose()).rowwise() + centre.transpose();
    const haptics::Opening opening {
        .centre = centre, .normal = turn.col(2), .along = turn.col(1), .length_mm = 60.0, .width_mm = width_mm
    };
    const haptics::StraightRod finger {}, instrument { .thickness_mm = 8.0, .taper_mm = 0.0, .reach_mm = 300.0 };
    const auto around = haptics::make_surroundings(
        lips, opening, mesh::deformed_boundary(tube_scene().body.mesh, {}), finger.thickness_mm);
    return { { "finger", std::make_shared<const haptics::FingerAccess>(around, opening, finger) },
        { "instrument", std::make_shared<const haptics::FingerAccess>(around, opening, instrument) } };
}

PalpationBackend tube_backend(std::shared_ptr<TubeControl> control)
{
    return { { "fem", "springs", "spheres" },
        [control](const datasets::PalpationScene& scene, const TissueChoice& wish, const Job& job) -> ChosenTissue {
            if (wish.model == "spheres")
                return { spheres(scene, wish), { "a tube of spheres" } };
            if (wish.model != "fem")
                throw InputError("springs do not hold this tube", wish.model);
            std::unique_ptr<haptics::TissueResponse> tissue = elements(scene, wish, control->pulse, job);
            if (!control->can_be_sick)
                return { std::move(tissue), {} };
            return { std::make_unique<SickTissue>(std::move(tissue), control), {} };
        } };
}

} // namespace retractor::planner
