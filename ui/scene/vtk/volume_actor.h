#pragma once
// CT volumes as VTK volume renderings, prepared once and kept.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <cstdint>
#include <memory>
#include <vector>

class vtkVolume;

namespace retractor::ui {

/// The image with hidden voxels, and those half filled at their border, turned to air. Voxels of `image` whose
/// centre lies in a hidden voxel of `mask`, and their neighbours, are hidden.
std::vector<std::int16_t> hide_voxels(const mesh::Volume& image, const VoxelMask& mask);

/// The volumes of the views of one window. A volume whose image, mask, crop box, preset and opacity were shown before
/// is not built again; those that no view has asked for since the last sweep() are let go.
class VolumeCache {
public:
    /// Records the part "volume rendering" for every image that is prepared.
    explicit VolumeCache(const Job& job = {});
    ~VolumeCache();
    VolumeCache(VolumeCache&&) noexcept;
    VolumeCache& operator=(VolumeCache&&) noexcept;

    vtkSmartPointer<vtkVolume> volume(const VolumeItem& item);
    void sweep();
    /// Coarser sampling while a camera moves.
    void set_interactive(bool interactive);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
