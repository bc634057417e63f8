// Selects the eye of a vertex and routes the vertex to that eye's layer. Define one of STEREO_MULTIVIEW,
// STEREO_LAYERED, STEREO_SINGLE.
#if defined(STEREO_MULTIVIEW)
#extension GL_EXT_multiview : require
int eyeIndex(int first) { return gl_ViewIndex; }
void routeEye() {}
#elif defined(STEREO_LAYERED)
#extension GL_ARB_shader_viewport_layer_array : require
int eyeIndex(int first) { return gl_InstanceIndex; }
void routeEye() { gl_Layer = gl_InstanceIndex; }
#else
int eyeIndex(int first) { return first; }
void routeEye() {}
#endif
