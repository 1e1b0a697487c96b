#pragma once
// Makes VTK volume renderings of CT volumes, prepared once and kept.

#include "mesh/base/job.h"
#include "ui/scene/scene.h"

#include <vtkSmartPointer.h>

#include <cstdint>
#include <memory>
#include <vector>

class vtkVolume;

namespace retractor::ui {

/// The image with hidden voxels turned to air. A voxel of `image` is hidden when its centre lies in a hidden voxel of
/// `mask`. The neighbours of hidden voxels are hidden too, because border voxels are half filled.
std::vector<std::int16_t> hide_voxels(const mesh::Volume& image, const VoxelMask& mask);

/// The volumes of the views of one window. A volume with the same image, mask, crop box, preset and opacity is not
/// built again. sweep() drops the volumes that no view has used since the last sweep().
class VolumeCache {
public:
    /// Records the part "volume rendering" in the ledger for every prepared image.
    explicit VolumeCache(const Job& job = {});
    ~VolumeCache();
    VolumeCache(VolumeCache&&) noexcept;
    VolumeCache& operator=(VolumeCache&&) noexcept;

    vtkSmartPointer<vtkVolume> volume(const VolumeItem& item);
    void sweep();
    /// Samples more coarsely while a camera moves.
    void set_interactive(bool interactive);

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace retractor::ui
