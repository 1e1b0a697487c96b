#include "haptics/servo/tissue_response.h"

namespace retractor {

TissueResponse::~TissueResponse() = default;

} // namespace retractor
