// SPDX-License-Identifier: BSD-3-Clause
// Which OpenGL context is current: see GlContext.h.
#include "viewer/offscreen/GlContext.h"

namespace kdstream
{
namespace
{

thread_local GlContext* currentContext = nullptr;

}

GlContext::~GlContext()
{
  if (currentContext == this)
  {
    currentContext = nullptr;
  }
}

Status GlContext::MakeCurrent()
{
  if (!this->IsCurrent())
  {
    if (currentContext && &currentContext->Library() != &this->Library())
    {
      currentContext->Unbind();
    }
    currentContext = nullptr;
    KDSTREAM_TRY(this->Bind());
    currentContext = this;
  }
  return UseGlLibrary(this->Library());
}

bool GlContext::IsCurrent() const
{
  return currentContext == this && this->IsBound();
}

void GlContext::LetGo()
{
  if (currentContext == this)
  {
    this->Unbind();
    currentContext = nullptr;
  }
}

}
