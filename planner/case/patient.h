#pragma once
// A patient's parts. A part is built when it is first asked for, so a scene that needs no CT loads none.
// Units mm; frame patient LPS.

#include "mesh/base/job.h"
#include "mesh/image/volume.h"
#include "planner/anatomy/anatomy.h"
#include "planner/anatomy/bone_stiffness.h"
#include "planner/case/case.h"
#include "planner/case/stiffness_factors.h"

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace retractor::planner {

/// Safe to use from several threads. A part that was handed out stays valid and unchanged.
class Patient {
public:
    /// Reads nothing yet. The job's ledger records the parts.
    explicit Patient(Case planned_case, Job job = {});

    const Case& planned_case() const { return case_; }
    const Job& job() const { return job_; }
    bool has_ct() const { return case_.ct.has_value(); }

    /// The CT ("voxels" in the ledger). @throws InputError when the case has none; IoError
    std::shared_ptr<const mesh::Volume> ct();
    /// The labels with the table of the case. @throws InputError, IoError
    std::shared_ptr<const mesh::LabelVolume> labels();
    /// The landmarks. @throws InputError as find_anatomy() does
    std::shared_ptr<const Anatomy> anatomy();
    /// The patient's own axes. Labels without a sternum give the axes of the frame (x left, y back, z head).
    /// @throws InputError as find_anatomy() does
    AnatomicalFrame frame();
    /// Moduli of ribs and cartilages, from the CT where the case has one that can be read.
    /// @throws InputError, IoError as labels(), and as find_bone_stiffness()
    std::shared_ptr<const std::vector<BoneStiffness>> bone_stiffness();
    /// Whether any voxel has this label. @throws InputError when the label is unknown
    bool has_voxels(std::string_view name);
    /// Closed surface of one label. @throws InputError when the label is unknown or has no voxel
    std::shared_ptr<const TriMesh> organ(std::string_view name);
    /// Surface of the whole wall before any cut, with the skin outside and the cavity inside.
    std::shared_ptr<const TriMesh> body();
    /// The faces that close the body where the image ends, see image_end_faces().
    std::shared_ptr<const TriMesh> image_end();
    /// Surface of a target: the surface of its label, the site on this surface, or a sphere.
    /// @throws InputError as organ() and site_surface() do
    std::shared_ptr<const TriMesh> target(const TargetSpec& target);

    /// Plans with other stiffness than the case's (planner/case/stiffness_factors.h). @pre no plan of this patient is
    /// under way
    void set_stiffness_factors(StiffnessFactors factors) { stiffness_factors_ = std::move(factors); }
    const StiffnessFactors& stiffness_factors() const { return stiffness_factors_; }

private:
    Case case_;
    Job job_;
    StiffnessFactors stiffness_factors_;
    std::recursive_mutex mutex_; ///< recursive: a part is built from other parts
    std::shared_ptr<const mesh::Volume> ct_;
    std::shared_ptr<const mesh::LabelVolume> labels_;
    std::shared_ptr<const Anatomy> anatomy_;
    std::shared_ptr<const std::vector<BoneStiffness>> bone_stiffness_;
    std::map<std::string, std::shared_ptr<const TriMesh>, std::less<>> organs_;
    std::shared_ptr<const TriMesh> body_, image_end_;
    mesh::LabelFlags label_occurs_; ///< one flag per label id; empty until first needed
};

/// The materials of the wall by label, as materials_as_solved() of the case, with the moduli of the patient's own ribs
/// and cartilages. Plans, live surgery and palpation take the materials from here.
/// @throws as Patient::bone_stiffness()
std::vector<fem::Material> materials_as_solved(Patient& patient, ElementKind element);
/// The materials for the kind of element that the case is solved with.
std::vector<fem::Material> materials_as_solved(Patient& patient);

/// A sphere as an icosahedron subdivided until its chords deviate by less than 0.2 % of the radius.
TriMesh sphere_surface(const Vec3& centre, double radius_mm);

/// Whether the label is of a patient's organ that the approach does not hold aside.
bool stays_in_place(const mesh::LabelInfo& label, const Approach& approach, Patient& patient);

} // namespace retractor::planner
