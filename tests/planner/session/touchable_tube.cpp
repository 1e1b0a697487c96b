#include "tests/planner/session/touchable_tube.h"

#include "datasets/phantoms/aorta_phantom.h"
#include "haptics/condensed/condensed_tissue.h"
#include "haptics/spheres/sphere_tissue.h"
#include "mesh/base/error.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <limits>

namespace retractor {

namespace {

    class SickTissue : public TissueResponse {
    public:
        SickTissue(std::unique_ptr<TissueResponse> tissue, std::shared_ptr<TubeControl> control)
            : tissue_(std::move(tissue))
            , control_(std::move(control))
        {
        }
        std::string_view name() const noexcept override { return tissue_->name(); }
        std::size_t finger_count() const noexcept override { return tissue_->finger_count(); }
        void tick(double time_s, double step_s, std::span<const Fingertip> fingers,
            std::span<FingerContact> contacts) noexcept override
        {
            tissue_->tick(time_s, step_s, fingers, contacts);
            if (control_->sick)
                contacts[0].force.setConstant(std::numeric_limits<double>::quiet_NaN());
        }
        const TriMesh& surface() const noexcept override { return tissue_->surface(); }
        void follow(Points& deformed) override { tissue_->follow(deformed); }

    private:
        std::unique_ptr<TissueResponse> tissue_;
        std::shared_ptr<TubeControl> control_;
    };

    std::unique_ptr<TissueResponse> elements(
        const PalpationScene& scene, const TissueWish& wish, bool pulse, const Job& job)
    {
        CondensedOptions options;
        options.element = TouchElement::p1; // quick to make; how stiff it is matters to no test here
        options.fingers = wish.fingers;
        options.rest_pressure = scene.rest_mmHg * kMPaPerMmHg;
        return std::make_unique<CondensedTissue>(scene.body,
            pulse ? PulsePressure::aortic(scene.heart_rate_per_min) : PulsePressure::constant(scene.rest_mmHg), options,
            job);
    }

    std::unique_ptr<TissueResponse> spheres(const PalpationScene& scene, const TissueWish& wish)
    {
        TriMesh surface { scene.body.mesh.vertices, {}, {} };
        for (const TetFace& face : boundary_faces(scene.body.mesh))
            surface.triangles.push_back(face_vertices(scene.body.mesh, face));
        SphereLaw law;
        law.fingers = wish.fingers;
        const SphereFilling filling = fill_with_spheres(surface, 0.6);
        return std::make_unique<SphereTissue>(std::vector<SphereOrgan> { { scene.name, surface, filling, 0.02 } }, law);
    }

} // namespace

PalpationScene tube_scene()
{
    AortaParameters parameters;
    parameters.shape = AortaParameters::Shape::tube;
    parameters.length_mm = 60.0;
    parameters.region.length_mm = 0.0;
    parameters.around = 16;
    parameters.along = 16;
    return make_aorta_phantom(parameters);
}

PalpationBackend tube_backend(std::shared_ptr<TubeControl> control)
{
    return { { "fem", "springs", "spheres" },
        [control](const PalpationScene& scene, const TissueWish& wish, const Job& job) -> MadeTissue {
            if (wish.model == "spheres")
                return { spheres(scene, wish), { "a tube of spheres" } };
            if (wish.model != "fem")
                throw InputError("springs do not hold this tube", wish.model);
            std::unique_ptr<TissueResponse> tissue = elements(scene, wish, control->pulse, job);
            if (!control->can_be_sick)
                return { std::move(tissue), {} };
            return { std::make_unique<SickTissue>(std::move(tissue), control), {} };
        } };
}

} // namespace retractor
