/* Embree's part in a comparison: see serve.rs for what is asked on standard input, scene.rs for the file. One ray a call, default
   quality and flags, one thread for the queries. Compiles with Embree 3 and Embree 4. */
#define _POSIX_C_SOURCE 200809L
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { KINDS = 3, SHADOW = 2 };
static const char *const names[KINDS] = {"primary", "bounce", "shadow"};

/* Origin, direction and length. */
typedef struct {
    float o[3], d[3], length;
} PackedRay;

static void fail(const char *what) {
    fprintf(stderr, "embree: %s\n", what);
    exit(1);
}

static void read_all(void *to, size_t size, size_t count, FILE *file) {
    if (fread(to, size, count, file) != count) fail("the file of rays is too short");
}

static double seconds(clockid_t clock) {
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static struct RTCRay unpack(const PackedRay *packed) {
    struct RTCRay ray;
    ray.org_x = packed->o[0], ray.org_y = packed->o[1], ray.org_z = packed->o[2];
    ray.dir_x = packed->d[0], ray.dir_y = packed->d[1], ray.dir_z = packed->d[2];
    ray.tnear = 0, ray.tfar = packed->length;
    ray.time = 0, ray.mask = -1, ray.id = 0, ray.flags = 0;
    return ray;
}

static inline void closest(RTCScene scene, const PackedRay *packed, struct RTCRayHit *query) {
    query->ray = unpack(packed);
    query->hit.geomID = query->hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
    rtcIntersect1(scene, query, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcIntersect1(scene, &context, query);
#endif
}

static inline int occluded(RTCScene scene, const PackedRay *packed) {
    struct RTCRay ray = unpack(packed);
#if RTC_VERSION_MAJOR >= 4
    rtcOccluded1(scene, &ray, NULL);
#else
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene, &context, &ray);
#endif
    return ray.tfar < 0;
}

static size_t count_hits(RTCScene scene, int kind, const PackedRay *rays, size_t count) {
    size_t hits = 0;
    for (size_t i = 0; i < count; i++) {
        if (kind == SHADOW) {
            hits += (size_t)occluded(scene, &rays[i]);
        } else {
            struct RTCRayHit query;
            closest(scene, &rays[i], &query);
            hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
        }
    }
    return hits;
}

static void write_answers(RTCScene scene, int kind, const PackedRay *rays, size_t count, const char *path) {
    FILE *file = fopen(path, "wb");
    if (!file) fail("cannot write answers");
    for (size_t i = 0; i < count; i++) {
        float t = INFINITY;
        uint32_t triangle = UINT32_MAX;
        if (kind == SHADOW) {
            if (occluded(scene, &rays[i])) t = 0;
        } else {
            struct RTCRayHit query;
            closest(scene, &rays[i], &query);
            if (query.hit.geomID != RTC_INVALID_GEOMETRY_ID) t = query.ray.tfar, triangle = query.hit.primID;
        }
        fwrite(&t, sizeof t, 1, file);
        fwrite(&triangle, sizeof triangle, 1, file);
    }
    if (fclose(file)) fail("cannot write answers");
}

static int kind_of(const char *name) {
    for (int kind = 0; kind < KINDS; kind++)
        if (!strcmp(name, names[kind])) return kind;
    fail("no such rays");
    return 0;
}

int main(int argc, char **argv) {
    FILE *file = argc == 2 ? fopen(argv[1], "rb") : NULL;
    if (!file) fail("usage: embree FILE");
    char magic[8];
    uint64_t counts[3];
    read_all(magic, 1, sizeof magic, file);
    if (memcmp(magic, "abberays", sizeof magic)) fail("not a file of rays");
    read_all(counts, sizeof *counts, 3, file);

    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = rtcNewScene(device);
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    void *vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, counts[0]);
    void *indices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, counts[1]);
    if (!vertices || !indices) fail("no room for the mesh");
    read_all(vertices, 12, counts[0], file);
    read_all(indices, 12, counts[1], file);
    const PackedRay *rays[KINDS];
    for (int kind = 0; kind < KINDS; kind++) {
        PackedRay *of_kind = malloc(counts[2] * sizeof *of_kind);
        if (!of_kind) fail("no room for the rays");
        read_all(of_kind, sizeof *of_kind, counts[2], file);
        rays[kind] = of_kind;
    }
    fclose(file);
    double start = seconds(CLOCK_MONOTONIC);
    rtcCommitGeometry(mesh);
    rtcAttachGeometry(scene, mesh);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("the scene was not built");
    printf("built in %.2f s by Embree " RTC_VERSION_STRING "\n", seconds(CLOCK_MONOTONIC) - start);
    fflush(stdout);

    char line[4096], name[16], path[4096];
    while (fgets(line, sizeof line, stdin)) {
        if (sscanf(line, "answers %15s %4095s", name, path) == 2) {
            int kind = kind_of(name);
            write_answers(scene, kind, rays[kind], counts[2], path);
            puts("written");
        } else if (sscanf(line, "%15s", name) == 1) {
            int kind = kind_of(name);
            double before = seconds(CLOCK_THREAD_CPUTIME_ID);
            size_t hits = count_hits(scene, kind, rays[kind], counts[2]);
            double spent = seconds(CLOCK_THREAD_CPUTIME_ID) - before;
            printf("%.3f %zu\n", 1e9 * spent / (double)counts[2], hits);
        }
        fflush(stdout);
    }
    return 0;
}
