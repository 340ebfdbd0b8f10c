/* Embree 4 driven the fastest way it offers: packets of coherent rays, called from compiled code.
 *
 * peer_packets.py compiles this file, linked to the libembree4 that the embreex package ships or the system has. No
 * Embree header is needed: what is used of the API is declared here after its reference manual
 * (github.com/RenderKit/embree, doc/src/api). Rays are made in Embree's own layout by one call and cast by another, so
 * that nothing but the intersect calls is timed.
 */
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* The manual's enumerators that are needed, by value. */
enum { TRIANGLES = 0, INDEX_BUFFER = 0, VERTEX_BUFFER = 1, UINT3 = 0x5003, FLOAT3 = 0x9003 };
enum { ROBUST = 1 << 2, COHERENT = 1 << 16, ALL_FEATURES = -1, NOTHING = -1, NATIVE_RAY8 = 33, NATIVE_RAY16 = 34 };

/* RTCIntersectArguments: two enums, three pointers, then fields of optional features; zero is "not used" in all. */
struct arguments {
    int flags, features;
    void *context, *filter, *intersect;
    char optional[32];
};

void *rtcNewDevice(const char *config);
void rtcReleaseDevice(void *device);
ptrdiff_t rtcGetDeviceProperty(void *device, int property);
void *rtcNewScene(void *device);
void rtcReleaseScene(void *scene);
void rtcSetSceneFlags(void *scene, int flags);
void rtcCommitScene(void *scene);
void *rtcNewGeometry(void *device, int type);
void *rtcSetNewGeometryBuffer(void *geometry, int type, unsigned slot, int format, size_t stride, size_t count);
void rtcCommitGeometry(void *geometry);
void rtcReleaseGeometry(void *geometry);
unsigned rtcAttachGeometry(void *scene, void *geometry);
void rtcIntersect1(void *scene, void *rays, struct arguments *);
void rtcIntersect8(const int *valid, void *scene, void *rays, struct arguments *);
void rtcIntersect16(const int *valid, void *scene, void *rays, struct arguments *);

/* Rows of a packet: twelve of the ray, nine of the hit (the last two name an instance, which we have none of). */
enum { ORIGIN, NEAR = 3, DIRECTION, TIME = 7, FAR, MASK, ID, FLAGS, NORMAL, PRIMITIVE = 17, GEOMETRY, INSTANCE, ROWS = 21 };
/* A single ray is padded to whole blocks of 16 bytes. */
enum { SINGLE_ROWS = 24 };

struct tracer {
    void *device, *scene;
    size_t rays, width;
    float *packets;
};

/* Whether this was compiled with threads. */
int tracer_has_threads(void)
{
#ifdef _OPENMP
    return 1;
#else
    return 0;
#endif
}

static int rows_of(size_t width) { return width == 1 ? SINGLE_ROWS : ROWS; }

/* A device and a scene of one mesh: vertices [v, 3] float, faces [f, 3] unsigned. */
struct tracer *tracer_new(const float *vertices, size_t v, const unsigned *faces, size_t f, const char *config)
{
    struct tracer *tracer = calloc(1, sizeof *tracer);
    tracer->device = rtcNewDevice(config);
    tracer->scene = rtcNewScene(tracer->device);
    rtcSetSceneFlags(tracer->scene, ROBUST);
    void *mesh = rtcNewGeometry(tracer->device, TRIANGLES);
    memcpy(rtcSetNewGeometryBuffer(mesh, VERTEX_BUFFER, 0, FLOAT3, 12, v), vertices, 12 * v);
    memcpy(rtcSetNewGeometryBuffer(mesh, INDEX_BUFFER, 0, UINT3, 12, f), faces, 12 * f);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(tracer->scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(tracer->scene);
    return tracer;
}

void tracer_free(struct tracer *tracer)
{
    rtcReleaseScene(tracer->scene);
    rtcReleaseDevice(tracer->device);
    free(tracer->packets);
    free(tracer);
}

/* The widest packet that this processor traces as it is: 16 with AVX-512, 8 with AVX. */
int native_width(void)
{
    void *device = rtcNewDevice(NULL);
    int width = rtcGetDeviceProperty(device, NATIVE_RAY16) ? 16 : rtcGetDeviceProperty(device, NATIVE_RAY8) ? 8 : 1;
    rtcReleaseDevice(device);
    return width;
}

/* Rays from one origin along `directions` [n, 3], `width` (1, 8 or 16) neighbours to a packet; n is a multiple of it. */
int tracer_rays(struct tracer *tracer, const float origin[3], const float *directions, size_t n, size_t width, float far)
{
    size_t bytes = n * rows_of(width) * sizeof(float);
    if (n % width || (width != 1 && width != 8 && width != 16)) return 0;
    if (tracer->rays != n || tracer->width != width) {
        free(tracer->packets);
        tracer->packets = aligned_alloc(64, (bytes + 63) / 64 * 64);
        tracer->rays = n;
        tracer->width = width;
    }
    memset(tracer->packets, 0, bytes);
    for (size_t ray = 0; ray < n; ray++) {
        float *lane = tracer->packets + ray / width * width * rows_of(width) + ray % width;
        for (int axis = 0; axis < 3; axis++) {
            lane[(ORIGIN + axis) * width] = origin[axis];
            lane[(DIRECTION + axis) * width] = directions[3 * ray + axis];
        }
        lane[FAR * width] = far;
        const int nothing = NOTHING;
        for (int row = PRIMITIVE; row < ROWS; row++) memcpy(lane + row * width, &nothing, 4);
        memcpy(lane + MASK * width, &nothing, 4);
    }
    return 1;
}

/* The closest hit of the rays that `tracer_rays` made; they shrink to it, so make them anew before the next cast. */
void tracer_cast(struct tracer *tracer, int threads)
{
    static const _Alignas(64) int valid[16] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    const size_t width = tracer->width, step = width * rows_of(width);
    const long packets = (long)(tracer->rays / width);
    void *scene = tracer->scene;
    (void)threads; /* without OpenMP */
#pragma omp parallel for schedule(dynamic, 64) num_threads(threads) if (threads > 1)
    for (long packet = 0; packet < packets; packet++) {
        struct arguments arguments = {.flags = COHERENT, .features = ALL_FEATURES};
        float *rays = tracer->packets + (size_t)packet * step;
        if (width == 1) rtcIntersect1(scene, rays, &arguments);
        else if (width == 8) rtcIntersect8(valid, scene, rays, &arguments);
        else rtcIntersect16(valid, scene, rays, &arguments);
    }
}

/* What the last cast found: distance [n], and the triangle [n], -1 on a miss. */
void tracer_hits(const struct tracer *tracer, float *distance, int32_t *triangle)
{
    const size_t width = tracer->width;
    for (size_t ray = 0; ray < tracer->rays; ray++) {
        const float *lane = tracer->packets + ray / width * width * rows_of(width) + ray % width;
        distance[ray] = lane[FAR * width];
        memcpy(triangle + ray, lane + PRIMITIVE * width, 4);
    }
}
