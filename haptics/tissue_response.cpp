#include "haptics/tissue_response.h"

namespace retractor {

TissueResponse::~TissueResponse() = default;

} // namespace retractor
