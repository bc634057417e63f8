// The terms that a page uses, explained in the words of the guide's glossary.
#pragma once

#include <vector>

#include "app/report/page.h"

namespace stylet::report {

// All terms of packaging/guide/glossary.md, in its order.
const std::vector<Fact>& glossary();

// Adds a section with the terms that occur in the page so far. Call last.
void addGlossary(Page&);

}  // namespace stylet::report
